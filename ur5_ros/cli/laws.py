"""Commands around laws and the course: declared here, done in ``commands``."""

from pathlib import Path
from typing import Annotated

import typer

from ur5_ros.cli.options import Json, Scheduler, Workers
from ur5_ros.cli.typer_app import app


@app.command()
def bench(
    law: Annotated[Path | None, typer.Option(
        metavar='FILE', help='A Python file with a class Law, beside the others.')] = None,
    quick: Annotated[bool, typer.Option(
        '--quick', help='Two perturbations, one seed: about a minute.')] = False,
    seeds: Annotated[int, typer.Option(
        metavar='N', min=1, max=1000, help='Seeds of each perturbation.')] = 5,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FOLDER', help='Folder for table and report; bench by default.',
    )] = None,
    scheduler: Scheduler = None,
    workers: Workers = None,
    gains: Annotated[Path | None, typer.Option(
        metavar='FILE', help='Gains that --tune found; those of the package by default.')] = None,
    law_timeout: Annotated[float, typer.Option(
        metavar='S', min=1.0, help='Wall time of a run with --law [s]; longer is too late.',
    )] = 60.0,
    tune: Annotated[Path | None, typer.Option(
        metavar='FILE', help='Search the gains anew and write them here instead.')] = None,
) -> int:
    """Compare the laws under perturbations (needs make setup-all)."""
    from ur5_ros.cli.commands import bench as work
    return work.bench(law, quick, seeds, out, scheduler, workers, gains, tune, law_timeout)


@app.command()
def grade(
    exercise: Annotated[str, typer.Argument(
        metavar='EXERCISE', show_default=False,
        help='kinematics, dynamics, computed_torque, identification, friction or contact.')],
    file: Annotated[Path, typer.Argument(
        metavar='FILE', help='The solution, a Python file.', show_default=False)],
    seed: Annotated[int, typer.Option(metavar='N', min=0, help='Seed of the questions.')] = 0,
    json: Json = None,
) -> int:
    """Judge a solution of the course, line by line."""
    from ur5_ros.cli.commands import course
    return course.grade_file(exercise, file, seed, json)
