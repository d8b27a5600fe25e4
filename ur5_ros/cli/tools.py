"""Commands around recordings, arms and running nodes: declared here, done in ``commands``."""

from pathlib import Path
from typing import Annotated

import typer

from ur5_ros.cli.options import (
    ArmName,
    Effort,
    Html,
    JointPrefix,
    Json,
    Run,
    Scheduler,
    ShownArm,
    Topics,
    Workers,
    arm_names,
)
from ur5_ros.cli.typer_app import app


@app.command('import')
def import_(
    log: Annotated[Path, typer.Argument(metavar='LOG.csv[.gz]', show_default=False)],
    out: Annotated[Path, typer.Option(
        '--out', metavar='RUN', help='Run folder to write.', show_default=False)],
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=arm_names,
        help='Arm that the log is of.')] = 'ur5_controller',
    columns: Annotated[str | None, typer.Option(
        metavar='NAME,...', help="ur_rtde's names in the order of the file, - skips one.")] = None,
) -> int:
    """Turn a robot's own log into a bag."""
    from ur5_ros.cli.commands import bags
    return bags.import_log(log, out, arm, columns)


@app.command()
def identify(
    runs: Annotated[list[Path] | None, typer.Argument(
        metavar='RUN...', help='Runs to fit; none with --payload and --arm alone.',
        show_default=False)] = None,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FILE', help='Arm file to write.')] = None,
    test: Annotated[Path | None, typer.Option(
        '--test', metavar='RUN', help='Run to test the result on.')] = None,
    payload: Annotated[Path | None, typer.Option(
        '--payload', metavar='RUN', help='Run with a load at the tool: its mass and centre.',
    )] = None,
    arm: ArmName = None,
    json: Json = None,
    html: Html = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
    effort: Effort = None,
) -> int:
    """Fit inertial and friction parameters, with errors."""
    from ur5_ros.cli.commands import identification
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, effort, arm)
    return identification.identify(runs or [], out, test, payload, arm, json, html, given)


@app.command()
def excite(
    out: Annotated[Path, typer.Option(
        '-o', '--out', metavar='FILE', help='Experiment file to write, with a JointTrajectory '
        'beside it.', show_default=False)],
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=arm_names,
        help='Arm whose limits the motion keeps.')] = 'ur5',
    seconds: Annotated[float, typer.Option(metavar='S', help='Length of the motion [s].')] = 30.0,
    budget: Annotated[float, typer.Option(
        metavar='S', help='Time that the search may take [s].')] = 120.0,
    acceleration: Annotated[float, typer.Option(
        metavar='A', help='Largest joint acceleration [rad/s^2].')] = 4.0,
    clearance: Annotated[float, typer.Option(
        metavar='M', help='Least distance from the table and from the arm itself [m].')] = 0.12,
    seed: Annotated[int, typer.Option(metavar='N', help='Seed of the search.')] = 0,
    json: Json = None,
) -> int:
    """Find a motion that excites every parameter of an arm."""
    from ur5_ros.cli.commands import identification
    return identification.excite(out, arm, seconds, budget, acceleration, clearance, seed, json)


@app.command()
def recover(
    run: Run,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FOLDER', help='Where to write; RUN.recovered by default.')] = None,
    json: Json = None,
) -> int:
    """Repair a bag after a crash; the original stays."""
    from ur5_ros.cli.commands import bags
    return bags.recover(run, out, json)


@app.command()
def sweep(
    spec: Annotated[str, typer.Argument(
        metavar='SPEC.yaml|report', help='What to run; or "report" and a sweep folder.',
        show_default=False)],
    folder: Annotated[Path | None, typer.Argument(
        metavar='FOLDER', help='The sweep folder that "report" draws.')] = None,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FOLDER', help='Sweep folder; sweeps/NAME by default.')] = None,
    scheduler: Scheduler = None,
    workers: Workers = None,
    only: Annotated[int | None, typer.Option(
        metavar='I', help='Repeat this one run and keep its bags.')] = None,
) -> int:
    """Run an experiment many times; the same command resumes (needs make setup-all)."""
    from ur5_ros.cli.commands import sweeps
    if spec == 'report':
        return sweeps.report(folder)
    return sweeps.sweep(spec, out, scheduler, workers, only)


@app.command()
def view(
    run: Annotated[Path | None, typer.Argument(metavar='RUN', help='Run folder.')] = None,
    live: Annotated[bool, typer.Option('--live', help='Show what runs now.')] = False,
    port: Annotated[int, typer.Option(metavar='N', help='Port on this machine.')] = 8080,
    arm: ShownArm = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
) -> int:
    """Show the arm in the browser."""
    from ur5_ros.cli.commands import pictures
    from ur5_ros.cli.reading import showing_options
    return pictures.view(run, live, port, showing_options(topic, joint_prefix, arm))


@app.command()
def render(
    run: Run,
    out: Annotated[Path, typer.Option(
        '-o', '--out', metavar='FILE', help='.png, .mp4 or .gif.', show_default=False)],
    arm: ShownArm = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
) -> int:
    """Make a picture, a video or an animation, off screen."""
    from ur5_ros.cli.commands import pictures
    from ur5_ros.cli.reading import showing_options
    return pictures.render(run, out, showing_options(topic, joint_prefix, arm))


@app.command()
def export(
    run: Run,
    out: Annotated[Path, typer.Option(
        '-o', '--out', metavar='FILE', show_default=False,
        help='.csv; .parquet, and .rrd for Rerun, need make setup-all.')],
    arm: ShownArm = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
) -> int:
    """Write a run as a table or a scene for other tools."""
    from ur5_ros.cli.commands import export as work
    from ur5_ros.cli.reading import showing_options
    return work.export(run, out, showing_options(topic, joint_prefix, arm))


@app.command()
def experiments() -> int:
    """List the experiments, a line each."""
    from ur5_ros.cli.commands import lists
    return lists.experiments()


@app.command('set', context_settings={'ignore_unknown_options': True})  # -1 is a value
def set_(
    node: Annotated[str, typer.Argument(metavar='NODE', help='Node, such as /ur5_sim.',
                                        show_default=False)],
    name: Annotated[str, typer.Argument(metavar='NAME', help='Parameter.', show_default=False)],
    value: Annotated[str, typer.Argument(metavar='VALUE', help='Value, written as in YAML.',
                                         show_default=False)],
) -> int:
    """Set a parameter of a running node."""
    from ur5_ros.cli.commands import live
    return live.set_parameter(node, name, value)


@app.command('arm')
def arm_(
    urdf_file: Annotated[Path | None, typer.Option(
        '--urdf', metavar='FILE', help='URDF of a UR robot, or a bag with one.')] = None,
    calibration: Annotated[Path | None, typer.Option(
        '--calibration', metavar='FILE', help='Calibration that ur_calibration wrote.')] = None,
    arm: Annotated[str | None, typer.Option(
        '--arm', metavar='NAME', autocompletion=arm_names,
        help='Arm that was calibrated; the nearest by default.')] = None,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FILE', help='Arm file to write.')] = None,
) -> int:
    """List the arms, or make an arm file."""
    from ur5_ros.cli.commands import arms
    return arms.arm(urdf_file, calibration, arm, out)


@app.command()
def urdf(
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=arm_names, help='Arm: a name or a file.')] = 'ur5',
    tf_prefix: Annotated[str, typer.Option(metavar='TEXT', help='Put before every name.')] = '',
    ros2_control: Annotated[bool, typer.Option(
        '--ros2-control', help='Add the tag of ros2_control for the simulator.')] = False,
) -> int:
    """Print the URDF of an arm, made from its arm file."""
    from ur5_ros.cli.commands import pictures
    return pictures.urdf(arm, tf_prefix, ros2_control)
