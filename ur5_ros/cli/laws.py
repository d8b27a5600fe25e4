"""Commands around laws and the course: declared here, done in ``commands``."""

from pathlib import Path
from typing import Annotated

import typer

from ur5_ros.cli.options import Json
from ur5_ros.cli.typer_app import app


@app.command()
def grade(
    exercise: Annotated[str, typer.Argument(
        metavar='EXERCISE', show_default=False,
        help='kinematics, dynamics, computed_torque, identification, friction or contact.')],
    file: Annotated[Path, typer.Argument(
        metavar='FILE', help='The solution, a Python file.', show_default=False)],
    seed: Annotated[int, typer.Option(metavar='N', min=0, help='Of the questions.')] = 0,
    json: Json = None,
) -> int:
    """Judge a solution of the course, line by line."""
    from ur5_ros.cli.commands import course
    return course.grade_file(exercise, file, seed, json)
