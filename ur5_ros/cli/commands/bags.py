"""Commands on bags: replay, import, recover."""

from collections.abc import Iterable
from pathlib import Path

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS, WITH_LOSS
from ur5_ros.cli.json_file import write_json
from ur5_ros.errors import InputError
from ur5_ros.wording import number_of


def replay(
    run: Path, rate: float, topics: list[str] | None, loop: bool, start: float,
    stop: float | None, clock: bool,
) -> int:
    """Publish a bag's messages; see ``ur5 replay --help``."""
    from ur5_ros.bag.playback import load_playback
    if not 0.0 < rate < float('inf'):
        raise InputError(f'--rate {rate:g}; give more than zero, 1 is real time')
    playback = load_playback(run, topics, start, stop, clock)
    for remark in playback.remarks:
        terminal.show_text(terminal.console(), f'note: {remark}')
    from ur5_ros.nodes.ros.environment import check_environment
    check_environment()  # the middleware is loaded with the next import
    from ur5_ros.nodes.replay import replay as publish
    with terminal.progress('replaying', float(playback.time[-1]) * 1e-9, 's') as advance:
        sent = publish(playback, rate, loop, advance)
    terminal.show_text(terminal.console(),
                       f'{number_of(sent, "message")} sent on {", ".join(playback.types)}')
    return SUCCESS


def recover(run: Path, out: Path | None, json: Path | None) -> int:
    """Repair a bag; exit 3 when a part of it is lost for good."""
    from ur5_ros.bag.recovery import recover as repair
    found = repair(run, out)
    _print(found.sentences())
    write_json(found.to_plain(), json)
    return SUCCESS if found.intact else WITH_LOSS


def import_log(log: Path, out: Path, arm: str, columns: str | None) -> int:
    """Turn a robot's own log into a bag; see ``ur5 import --help``."""
    from ur5_ros.analysis.data.logs.robot_log import import_log as convert
    _print(convert(log, out, arm, columns))
    terminal.show_next(terminal.console(), f'ur5 validate {out}', 'is the model right?')
    return SUCCESS


def _print(sentences: Iterable[str]) -> None:
    for sentence in sentences:
        terminal.show_text(terminal.console(), sentence)
