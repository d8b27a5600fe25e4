"""The command ``ur5 grade``: a solution of the course judged."""

from pathlib import Path
from typing import Any

from rich.text import Text

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import FAILED, SUCCESS
from ur5_ros.cli.json_file import write_json
from ur5_ros.course.grade import Grade, grade


def grade_file(exercise: str, file: Path, seed: int, json: Path | None) -> int:
    """Judge a solution; see ``ur5 grade --help``."""
    found, screen = grade(exercise, file, seed), terminal.console()
    if found.why:
        terminal.show_text(screen, found.why)
    for mark in () if found.why else found.marks:
        words = f'{mark.points:g}/{mark.of:g}  {mark.line}'
        words += f': {mark.reason}' if mark.reason else ''
        words += f' - {mark.mistake}' if mark.mistake else ''
        terminal.show_text(screen, words)
    screen.print(Text(f'{found.points:g} of {sum(mark.of for mark in found.marks):g} points'),
                 soft_wrap=True)
    write_json(as_data(found), json)
    return SUCCESS if found.full else FAILED


def as_data(found: Grade) -> dict[str, Any]:
    """Return a grade as the JSON document has it."""
    return {'exercise': found.exercise, 'seed': found.seed, 'points': found.points,
            'full': found.full, 'why': found.why,
            'lines': [mark._asdict() for mark in found.marks]}
