"""Every command of ``ur5`` with its options; each command imports what it needs."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name='ur5', rich_markup_mode=None, pretty_exceptions_enable=False,
    context_settings={'help_option_names': ['-h', '--help'], 'max_content_width': 99},
    help='Torque control of simulated UR arms. Exit codes: 0 passed or done, 1 failed, '
    '2 bad input, 3 done with loss, 4 internal error.')


def _names(kind: str) -> Callable[[str], list[str]]:
    """Return what completes a name of config/``kind``; file names are left to the shell."""
    def complete(incomplete: str) -> list[str]:
        from ur5_ros.config.strict_yaml import config_folder
        names = sorted(path.stem for path in (config_folder() / kind).glob('*.yaml'))
        return [name for name in names if name.startswith(incomplete)]
    return complete


_arms, _experiments = _names('arms'), _names('experiments')

Run = Annotated[Path, typer.Argument(metavar='RUN', help='Run folder.', show_default=False)]
ArmName = Annotated[str | None, typer.Option(
    '--arm', metavar='NAME', autocompletion=_arms,
    help='Arm of the simulator, where the bag names none.')]
ControlArm = Annotated[str | None, typer.Option(
    '--control-arm', metavar='NAME', autocompletion=_arms,
    help='Arm of the controller, where the bag names none.')]
Topics = Annotated[list[str] | None, typer.Option(
    '--topic', metavar='ROLE=NAME', help='Topic of a role, as joint_states; repeat for more.')]
JointPrefix = Annotated[str | None, typer.Option(
    '--joint-prefix', metavar='TEXT', help='Text before the joint names.')]
Effort = Annotated[str | None, typer.Option(
    '--effort', metavar='MEANING',
    help='What effort is: total, gravity_excluded, target, current, other_sign.')]
ShownArm = Annotated[str | None, typer.Option(
    '--arm', metavar='NAME', autocompletion=_arms, help='Arm, where the bag names none.')]
Json = Annotated[Path | None, typer.Option('--json', metavar='FILE', help='Result as JSON.')]
Html = Annotated[Path | None, typer.Option('--html', metavar='FILE', help='Report, one file.')]


def _show_version(given: bool) -> None:
    if given:
        from ur5_ros import __version__
        print(f'ur5 {__version__}')
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[bool, typer.Option(
        '--version', callback=_show_version, is_eager=True, help='Show the version and exit.',
    )] = False,
) -> None:
    pass


@app.command()
def demo(
    experiment: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=_experiments,
        help='Experiment: a name of config/experiments or a file.',
    )] = 'kebria_fig11',
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=_arms, help='Arm to simulate.')] = 'ur5',
    control_arm: Annotated[str | None, typer.Option(
        metavar='NAME', autocompletion=_arms,
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
    from ur5_ros.cli import demo as work
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
        metavar='N[,N...]', help='Velocity gain, likewise.')] = None,
    reference: Annotated[str, typer.Option(
        metavar='TEXT', help='What the controller should follow: a topic, an experiment, six '
        'joint angles or a tool pose.')] = '',
    marks: Annotated[Path | None, typer.Option(
        '--marks', metavar='FILE', help='Pass marks, of the form of config/validation.yaml; '
        'those left out keep their default.')] = None,
    json: Json = None,
    html: Html = None,
    junit: Annotated[Path | None, typer.Option(
        '--junit', metavar='FILE', help='Result as JUnit XML.')] = None,
    topic: Topics = None,
    joint_prefix: JointPrefix = None,
    effort: Effort = None,
) -> int:
    """Judge a run by its bags alone."""
    from ur5_ros.cli import judge
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, effort, arm, control_arm, kp, kd)
    if reference:
        given['reference'] = reference
    return judge.validate(run, folder, given, marks, json, html, junit)


@app.command(name='warm-up')
def warm_up() -> int:
    """Compile for this processor what nodes, demo and validation need."""
    from ur5_ros.cli import warm_up as work
    return work.warm_up()


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
    from ur5_ros.cli import judge
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, None, arm)
    return judge.compare(run_a, run_b, json, {**given, 'keep_arm': True})


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
    from ur5_ros.cli import bags
    return bags.replay(run, rate, topics, loop, start, stop, clock)


@app.command()
def resimulate(run: Run, json: Json = None) -> int:
    """Play recorded commands into a new simulator: the same states?"""
    from ur5_ros.cli import repeat
    return repeat.resimulate(run, json)


@app.command()
def recontrol(run: Run, json: Json = None) -> int:
    """Play recorded states into the law: the same commands?"""
    from ur5_ros.cli import repeat
    return repeat.recontrol(run, json)


@app.command('import')
def import_(
    log: Annotated[Path, typer.Argument(metavar='LOG.csv[.gz]', show_default=False)],
    out: Annotated[Path, typer.Option(
        '--out', metavar='RUN', help='Run folder to write.', show_default=False)],
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=_arms, help='Arm that the log is of.')] = 'ur5_controller',
    columns: Annotated[str | None, typer.Option(
        metavar='NAME,...', help="ur_rtde's names in the order of the file, - skips one.")] = None,
) -> int:
    """Turn a robot's own log into a bag."""
    from ur5_ros.cli import bags
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
    from ur5_ros.cli import identification
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, effort, arm)
    return identification.identify(runs or [], out, test, payload, arm, json, html, given)


@app.command()
def excite(
    out: Annotated[Path, typer.Option(
        '-o', '--out', metavar='FILE', help='Experiment file to write, with a JointTrajectory '
        'beside it.', show_default=False)],
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=_arms, help='Arm whose limits hold.')] = 'ur5',
    seconds: Annotated[float, typer.Option(metavar='S', help='Length of the motion.')] = 30.0,
    budget: Annotated[float, typer.Option(
        metavar='S', help='Time that the search may take.')] = 120.0,
    acceleration: Annotated[float, typer.Option(
        metavar='A', help='Largest joint acceleration [rad/s^2].')] = 4.0,
    clearance: Annotated[float, typer.Option(
        metavar='M', help='Least distance from the table and from the arm itself [m].')] = 0.12,
    seed: Annotated[int, typer.Option(metavar='N', help='Seed of the search.')] = 0,
    json: Json = None,
) -> int:
    """Find a motion that excites every parameter of an arm."""
    from ur5_ros.cli import identification
    return identification.excite(out, arm, seconds, budget, acceleration, clearance, seed, json)


@app.command()
def recover(
    run: Run,
    out: Annotated[Path | None, typer.Option(
        '-o', '--out', metavar='FOLDER', help='Where to write; RUN.recovered by default.')] = None,
    json: Json = None,
) -> int:
    """Repair a bag after a crash; the original stays."""
    from ur5_ros.cli import bags
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
    scheduler: Annotated[str | None, typer.Option(
        metavar='ADDRESS', help='Dask scheduler; all cores here if none is given.')] = None,
    workers: Annotated[int | None, typer.Option(
        metavar='N', help='Worker processes here; one a core if not given.')] = None,
    only: Annotated[int | None, typer.Option(
        metavar='I', help='Repeat this one run and keep its bags.')] = None,
) -> int:
    """Run an experiment many times; the same command resumes."""
    from ur5_ros.cli import sweeps
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
    from ur5_ros.cli import pictures
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, None, arm)
    return pictures.view(run, live, port, {**given, 'keep_arm': True})


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
    from ur5_ros.cli import pictures
    from ur5_ros.cli.reading import reading_options
    given = reading_options(topic, joint_prefix, None, arm)
    return pictures.render(run, out, {**given, 'keep_arm': True})


@app.command()
def export(
    run: Run,
    out: Annotated[Path, typer.Option(
        '-o', '--out', metavar='FILE', help='.csv, .parquet, or .rrd for Rerun.',
        show_default=False)],
) -> int:
    """Write a run as a table or a scene for other tools."""
    from ur5_ros.cli import export as work
    return work.export(run, out)


@app.command()
def arm() -> int:
    """List the arms, a line each."""
    from ur5_ros.cli import lists
    return lists.arms()


@app.command()
def experiments() -> int:
    """List the experiments, a line each."""
    from ur5_ros.cli import lists
    return lists.experiments()


@app.command('set', context_settings={'ignore_unknown_options': True})  # -1 is a value
def set_(
    node: Annotated[str, typer.Argument(metavar='NODE', help='Such as /ur5_sim.',
                                        show_default=False)],
    name: Annotated[str, typer.Argument(metavar='NAME', help='Parameter.', show_default=False)],
    value: Annotated[str, typer.Argument(metavar='VALUE', help='As in YAML.',
                                         show_default=False)],
) -> int:
    """Set a parameter of a running node."""
    from ur5_ros.cli import live
    return live.set_parameter(node, name, value)


@app.command()
def urdf(
    arm: Annotated[str, typer.Option(
        metavar='NAME', autocompletion=_arms, help='Arm: a name or a file.')] = 'ur5',
    tf_prefix: Annotated[str, typer.Option(metavar='TEXT', help='Put before every name.')] = '',
    ros2_control: Annotated[bool, typer.Option(
        '--ros2-control', help='With the tag of ros2_control for the simulator.')] = False,
) -> int:
    """Print the URDF of an arm, made from its arm file."""
    from ur5_ros.cli import pictures
    return pictures.urdf(arm, tf_prefix, ros2_control)
