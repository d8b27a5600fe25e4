"""Commands that run and judge: declared here, done in ``commands``."""

from pathlib import Path
from typing import Annotated

import typer

from ur5_ros.cli.options import (
    ArmName,
    ControlArm,
    Effort,
    Html,
    JointPrefix,
    Json,
    Run,
    ShownArm,
    Topics,
    arm_names,
    experiment_names,
)
from ur5_ros.cli.typer_app import app


@app.command()
def demo(
    experiment: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=experiment_names,
        help='Experiment: a name of config/experiments or a file.',
    )] = 'kebria_fig11',
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=arm_names, help='Arm to simulate.')] = 'ur5',
    control_arm: Annotated[str | None, typer.Option(
        metavar='NAME', autocompletion=arm_names,
        help='Arm of the controller; another one: robustness experiment.')] = None,
    control_rate: Annotated[int, typer.Option(metavar='HZ', help='Control periods a second.')]
    = 1000,
    run: Annotated[Path | None, typer.Option(
        metavar='FOLDER', help='Run folder; it must not exist.')] = None,
    gui: Annotated[bool, typer.Option('--gui', help="Open PyBullet's window.")] = False,
    composed: Annotated[bool, typer.Option('--composed', help='Both nodes in one process.')]
    = False,
) -> int:
    """Run both nodes on the paper's experiment and judge it."""
    from ur5_ros.cli.commands import demo as work
    return work.demo(experiment, arm, control_arm, control_rate, run, gui, composed)


@app.command()
def validate(
    run: Annotated[Path | None, typer.Argument(
        metavar='RUN', help='Run folder; the newest below bags/ if none is given.')] = None,
    folder: Annotated[Path | None, typer.Option(
        '--all', metavar='FOLDER', help='Every run below a folder.')] = None,
    arm: ArmName = None,
    control_arm: ControlArm = None,
    kp: Annotated[str | None, typer.Option(
        metavar='N[,N...]', help='Position gain, where the bag has none: 1, 6 or 36.')] = None,
    kd: Annotated[str | None, typer.Option(
        metavar='N[,N...]', help='Velocity gain, where the bag has none: 1, 6 or 36.')] = None,
    reference: Annotated[str, typer.Option(
        metavar='TEXT', help='Topic, experiment, joints or pose to be followed.')] = '',
    marks: Annotated[Path | None, typer.Option(
        '--marks', metavar='FILE', help='Limits, of the form of config/validation.yaml.')] = None,
    json: Json = None,
    html: Html = None,
    junit: Annotated[Path | None, typer.Option(
        '--junit', metavar='FILE', help='Result as JUnit XML.')] = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
    effort: Effort = None,
) -> int:
    """Judge a run by its bags alone."""
    from ur5_ros.cli.commands import judge
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, effort, arm, control_arm, kp, kd)
    if reference:
        given['reference'] = reference
    return judge.validate(run, folder, given, marks, json, html, junit)


@app.command(name='warm-up')
def warm_up(
    everything: Annotated[bool, typer.Option(
        '--all', help='Also for contact, force control and pictures.')] = False,
) -> int:
    """Compile for this processor, before the first run."""
    from ur5_ros.cli.commands import warm_up as work
    return work.warm_up(everything)


@app.command()
def compare(
    run_a: Annotated[Path, typer.Argument(metavar='RUN_A', show_default=False)],
    run_b: Annotated[Path, typer.Argument(metavar='RUN_B', show_default=False)],
    json: Json = None,
    arm: ShownArm = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
) -> int:
    """Compare two runs: where do they start to differ?"""
    from ur5_ros.cli.commands import judge
    from ur5_ros.cli.reading import showing_options
    return judge.compare(run_a, run_b, json, showing_options(topic, joint_prefix, arm))


@app.command()
def replay(
    run: Run,
    rate: Annotated[float, typer.Option(metavar='R', help='Times real time.')] = 1.0,
    topics: Annotated[list[str] | None, typer.Option(
        metavar='TOPIC', help='Only this topic; repeat for more.')] = None,
    loop: Annotated[bool, typer.Option('--loop', help='Start again at the end.')] = False,
    start: Annotated[float, typer.Option(metavar='S', help='Start here [s].')] = 0.0,
    stop: Annotated[float | None, typer.Option(metavar='S', help='Stop here [s].')] = None,
    clock: Annotated[bool, typer.Option(help='Publish /clock.')] = True,
) -> int:
    """Publish a bag's messages on their topics."""
    from ur5_ros.cli.commands import bags
    return bags.replay(run, rate, topics, loop, start, stop, clock)


@app.command()
def resimulate(run: Run, json: Json = None) -> int:
    """Play recorded commands into a new simulator: the same states?"""
    from ur5_ros.cli.commands import repeat
    return repeat.resimulate(run, json)


@app.command()
def recontrol(run: Run, json: Json = None) -> int:
    """Play recorded states into the law: the same commands?"""
    from ur5_ros.cli.commands import repeat
    return repeat.recontrol(run, json)
