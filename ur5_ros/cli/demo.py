"""The command ``ur5 demo``: both nodes, one experiment, the verdict."""

import json
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

from rich.text import Text

from ur5_ros.bag.folder import new_run_name
from ur5_ros.bag.reader import open_bag
from ur5_ros.cli import judge, terminal
from ur5_ros.cli.bag_growth import BagGrowth
from ur5_ros.cli.exit_codes import NO, YES
from ur5_ros.cli.processes import GRACE, NodeProcesses, last_core
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete, load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import initial_positions
from ur5_ros.errors import Refusal

#: Physics steps a second that the demo does not go below [Hz].
PHYSICS_RATE = 1000

#: Wall-clock time without a new state after which the demo gives up [s].
PATIENCE = 120.0

_NODES = {'sim': 'ur5_ros.nodes.sim_node', 'control': 'ur5_ros.nodes.control_node'}


def demo(
    experiment: str, arm: str, control_arm: str | None, control_rate: int, run: Path | None,
    gui: bool,
) -> int:
    """Run and judge an experiment; see ``ur5 demo --help``."""
    parameters, duration = plan(experiment, arm, control_arm or arm, control_rate, gui)
    folder = run if run is not None else judge.BAGS / new_run_name()
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        raise Refusal(f'run folder {folder} exists; give another one, or remove it') from None
    out = terminal.console()
    out.print(f'{experiment}: {duration:g} s at {control_rate} Hz, {arm} under the law of '
              f'{control_arm or arm}', soft_wrap=True)
    seconds = record(folder, parameters, duration, control_rate)
    out.print(f'{duration:g} s in {seconds:.1f} s of wall clock: '
              f'{duration / seconds:.1f} times real time', soft_wrap=True)
    result = judge.judge(folder)
    judge.write(result, folder / 'result.json', folder / 'report.html', None)
    terminal.show_result(out, result)
    for topic, digest in hashes(folder).items():
        out.print(f'sha256 of {topic}: {digest}', soft_wrap=True)
    out.print(Text(f'report: {folder / "report.html"}'), soft_wrap=True)
    return YES if result.passed else NO


def plan(
    experiment: str, arm: str, control_arm: str, control_rate: int, gui: bool = False,
) -> tuple[dict[str, dict[str, Any]], float]:
    """
    Return the parameters of both nodes for an experiment, and its duration.

    Parameters
    ----------
    experiment, arm, control_arm : str
        Names or files.
    control_rate : int
        Control periods a second [Hz]; the physics takes the whole multiple of it that reaches
        1000 Hz.
    gui : bool, optional
        Open PyBullet's window.

    Returns
    -------
    parameters : dict
        ``'sim'`` and ``'control'`` to the parameters that differ from their defaults.
    duration : float
        Simulated time [s].

    Raises
    ------
    Refusal
        If a name is unknown or a value out of range.

    """
    spec = load_experiment(experiment)
    law_arm = load_arm(control_arm)
    if not load_arm(arm).has_tensors:
        raise Refusal(f'arm {arm} has point masses, which cannot be simulated; '
                      'give ur5 or ur5_real')
    sub_steps = -(-PHYSICS_RATE // control_rate) if control_rate > 0 else 1
    sim = {
        'arm': arm, 'control_rate': control_rate, 'physics_rate': control_rate * sub_steps,
        'initial_positions': [float(q) for q in initial_positions(spec, law_arm)],
        'stop_after': float(spec.duration), 'gui': gui,
    }
    control = {'arm': control_arm, 'experiment': experiment, 'autostart': True}
    complete(SIM_PARAMETERS, sim)
    complete(CONTROL_PARAMETERS, control)
    return {'sim': sim, 'control': control}, float(spec.duration)


def record(
    folder: Path, parameters: dict[str, dict[str, Any]], duration: float, control_rate: int,
) -> float:
    """
    Run both nodes in lockstep until the simulator has reached the end, recording into ``folder``.

    Parameters
    ----------
    folder : Path
        Run folder, which exists.
    parameters : dict
        As returned by :func:`plan`.
    duration : float
        Simulated time [s].
    control_rate : int
        Control periods a second [Hz].

    Returns
    -------
    float
        Wall-clock time from the first state to the last [s].

    Raises
    ------
    Refusal
        If a node ends early or nothing moves for two minutes; its own last line is in it.

    """
    with tempfile.TemporaryDirectory(prefix='ur5-demo-') as logs:
        with NodeProcesses(Path(logs), core=last_core()) as nodes:
            nodes.environment.setdefault('ROS_LOG_DIR', logs)
            for name, module in _NODES.items():
                nodes.start(name, module,
                            {**parameters[name], 'bag': str((folder / name).absolute())})
            seconds = _watch(nodes, BagGrowth(folder / 'sim'), duration, control_rate)
            for name in reversed(_NODES):
                code = nodes.end(name)
                if code != 0:
                    raise Refusal(f'{name}_node ended with code {code}: {nodes.last_words(name)}')
        for log in Path(logs).glob('*_node.log'):
            shutil.copy(log, folder)
    return seconds


def _watch(nodes: NodeProcesses, growth: BagGrowth, duration: float, control_rate: int) -> float:
    """Wait for the simulator's end; return the wall-clock time since the first states [s]."""
    began = moved = time.monotonic()
    states = 0
    with terminal.progress('simulating', duration, 's') as advance:
        while nodes.wait('sim', 0.1) is None:
            now = time.monotonic()
            if growth.messages() > states:
                began = now if states == 0 else began
                states, moved = growth.messages(), now
                advance(min(states / control_rate, duration))
            code = nodes.poll('control')
            if code is not None and nodes.wait('sim', GRACE) is None:
                raise Refusal(f'control_node ended with code {code}: '
                              f'{nodes.last_words("control")}')
            if now - moved > PATIENCE:
                raise Refusal(f'no new state for {PATIENCE:g} s; sim_node says: '
                              f'{nodes.last_words("sim")}')
    return time.monotonic() - began


def hashes(folder: Path) -> dict[str, str]:
    """Return topic to SHA-256 of its payloads, as the simulator's bag has it."""
    summary = open_bag(folder / 'sim').notes.get('summary', {})
    found = summary.get('hashes', {})
    return json.loads(found) if isinstance(found, str) else dict(found)
