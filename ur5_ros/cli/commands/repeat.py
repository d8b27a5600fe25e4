"""Commands that repeat a recording: resimulate and recontrol."""

from collections.abc import Callable
from pathlib import Path

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import Run
from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import FAILED, SUCCESS
from ur5_ros.cli.json_file import write_json
from ur5_ros.loop.repeat import Repetition
from ur5_ros.loop.repeat import recontrol as recontrolled
from ur5_ros.loop.repeat import resimulate as resimulated


def resimulate(run: Path, json: Path | None) -> int:
    """Play recorded commands into a new simulator; see ``ur5 resimulate --help``."""
    return _repeat(run, resimulated, json)


def recontrol(run: Path, json: Path | None) -> int:
    """Play recorded states into the law; see ``ur5 recontrol --help``."""
    return _repeat(run, recontrolled, json)


def _repeat(folder: Path, repeat: Callable[[Run], Repetition], json: Path | None) -> int:
    run = load_run(folder)
    found = repeat(run)
    terminal.show_text(terminal.console(), f'{run.name}: {found.sentence}')
    write_json({'format': 'ur5_ros repetition', 'version': 1, 'run': run.name,
                'equal': found.equal, **found._asdict()}, json)
    return SUCCESS if found.equal else FAILED
