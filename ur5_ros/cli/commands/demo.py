"""The command ``ur5 demo``: both nodes, one experiment, the verdict."""

from pathlib import Path

from rich.text import Text

from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.run_folders import BAGS, new_run_name
from ur5_ros.cli import terminal
from ur5_ros.cli.commands import judge
from ur5_ros.cli.exit_codes import FAILED, SUCCESS
from ur5_ros.errors import InputError
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.run_config import run_config


def demo(
    experiment: str, arm: str, control_arm: str | None, control_rate: int, run: Path | None,
    gui: bool, composed: bool = False,
) -> int:
    """Run and judge an experiment; see ``ur5 demo --help``."""
    config = run_config(experiment, arm, control_arm, control_rate, sim={'gui': gui})
    folder = run if run is not None else BAGS / new_run_name()
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        raise InputError(f'run folder {folder} exists; give another one, or remove it') from None
    out = terminal.console()
    terminal.show_text(out, f'{experiment}: {config.duration:g} s at {control_rate} Hz, arm '
                       f'{arm}, law of {control_arm or arm}; recording into {folder}')
    with terminal.progress('simulating', config.duration, 's') as advance:
        seconds = run_two_nodes(config, folder, advance, composed)
    terminal.show_text(out, f'{config.duration:g} s in {seconds:.1f} s of wall clock: '
                       f'{config.duration / seconds:.1f} times real time')
    result = judge.judge(folder)
    judge.write(result, folder / 'result.json', folder / 'report.html', None)
    terminal.show_result(out, result)
    for topic, digest in hashes(folder).items():
        out.print(f'sha256 of {topic}: {digest}', soft_wrap=True)
    out.print(Text(f'report: {folder / "report.html"}'), soft_wrap=True)
    terminal.show_next(out, f'ur5 view {folder}', 'the arm in the browser')
    return SUCCESS if result.passed else FAILED


def hashes(folder: Path) -> dict[str, str]:
    """Return topic to SHA-256 of its payloads, as the simulator's bag has it."""
    return dict(open_bag(folder / 'sim').notes.get('summary', {}).get('hashes', {}))
