"""One run by the two nodes as processes, in lockstep; the caller needs no ROS."""

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete
from ur5_ros.errors import InputError
from ur5_ros.launcher.node_processes import GRACE, NodeProcesses, shared_core
from ur5_ros.launcher.progress import BagGrowth
from ur5_ros.loop.run_config import Plan

#: Wall-clock time without a new state after which a run is given up [s].
START_TIMEOUT = 120.0

_DEFAULTS = {'sim': complete(SIM_PARAMETERS, {}), 'control': complete(CONTROL_PARAMETERS, {})}

_NODES = {'sim': 'ur5_ros.nodes.sim_node', 'control': 'ur5_ros.nodes.control_node'}


def run_two_nodes(
    plan: Plan, folder: Path, progress: Callable[[float], None] = lambda seconds: None,
) -> float:
    """
    Run both nodes until the simulator has reached the end, recording into ``folder``.

    Parameters
    ----------
    plan : Plan
        Parameters of both; ``bag`` is set here.
    folder : Path
        Run folder, which exists and is empty.
    progress : callable, optional
        Is told the simulated time [s] every tenth of a second.

    Returns
    -------
    float
        Wall-clock time from the first state to the last [s].

    Raises
    ------
    InputError
        If a node ends early or nothing moves for two minutes; its own last line is in it.

    """
    parameters = {'sim': plan.sim, 'control': plan.control}
    with tempfile.TemporaryDirectory(prefix='ur5-run-') as logs, \
            NodeProcesses(Path(logs)) as nodes:
        nodes.environment.setdefault('ROS_LOG_DIR', logs)
        if plan.sim['lockstep']:
            nodes.environment.setdefault('UR5_ROS_CORE', shared_core())
        for name, module in _NODES.items():
            bag = str((folder / name).absolute())
            given = {key: value for key, value in parameters[name].items()
                     if value != _DEFAULTS[name][key]}
            nodes.start(name, module, {**given, 'bag': bag})
        try:
            seconds = _watch(nodes, BagGrowth(folder / 'sim'), plan, progress)
            for name in _NODES:
                code = nodes.end(name)
                if code != 0:
                    raise InputError(f'{name}_node ended with code {code}: '
                                     f'{nodes.last_log_line(name)}')
        finally:
            for name in _NODES:
                shutil.copy(Path(logs) / f'{name}.log', folder)
    return seconds


def _watch(nodes: NodeProcesses, growth: BagGrowth, plan: Plan,
           progress: Callable[[float], None]) -> float:
    """Wait for the simulator's end; return the wall-clock time since the first states [s]."""
    began = moved = time.monotonic()
    states = 0
    while nodes.wait('sim', 0.1) is None:
        now = time.monotonic()
        if growth.messages() > states:
            began = now if states == 0 else began
            states, moved = growth.messages(), now
            progress(min(states / plan.sim['control_rate'], plan.duration))
        code = nodes.poll('control')
        if code is not None and nodes.wait('sim', GRACE) is None:
            raise InputError(f'control_node ended with code {code}: '
                             f'{nodes.last_log_line("control")}')
        if now - moved > START_TIMEOUT:
            raise InputError(f'no new state for {START_TIMEOUT:g} s; sim_node says: '
                             f'{nodes.last_log_line("sim")}')
    return time.monotonic() - began
