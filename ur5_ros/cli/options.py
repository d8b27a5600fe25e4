"""Options that several commands share."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer


def _names(kind: str) -> Callable[[str], list[str]]:
    """Return what completes a name of config/``kind``; file names are left to the shell."""
    def complete(incomplete: str) -> list[str]:
        from ur5_ros.config.strict_yaml import config_folder
        names = sorted(path.stem for path in (config_folder() / kind).glob('*.yaml'))
        return [name for name in names if name.startswith(incomplete)]
    return complete


arm_names, experiment_names = _names('arms'), _names('experiments')

Run = Annotated[Path, typer.Argument(metavar='RUN', help='Run folder.', show_default=False)]
ArmName = Annotated[str | None, typer.Option(
    '--arm', metavar='NAME', autocompletion=arm_names,
    help='Arm of the simulator, where the bag names none.')]
ControlArm = Annotated[str | None, typer.Option(
    '--control-arm', metavar='NAME', autocompletion=arm_names,
    help='Arm of the controller, where the bag names none.')]
Topics = Annotated[list[str] | None, typer.Option(
    '--topic', metavar='ROLE=NAME', help='Topic of a role, as joint_states; repeat for more.')]
JointPrefix = Annotated[str | None, typer.Option(
    '--joint-prefix', metavar='TEXT', help='Text before the joint names.')]
Effort = Annotated[str | None, typer.Option(
    '--effort', metavar='MEANING',
    help='What effort is: total, gravity_excluded, target, current, other_sign.')]
ShownArm = Annotated[str | None, typer.Option(
    '--arm', metavar='NAME', autocompletion=arm_names, help='Arm, where the bag names none.')]
Json = Annotated[Path | None, typer.Option('--json', metavar='FILE', help='Result as JSON.')]
Html = Annotated[Path | None, typer.Option('--html', metavar='FILE', help='Report, one file.')]
Scheduler = Annotated[str | None, typer.Option(
    '--scheduler', metavar='ADDRESS', help='Dask scheduler; all cores here if none is given.')]
Workers = Annotated[int | None, typer.Option(
    '--workers', metavar='N', help='Worker processes here; one a core if not given.')]
