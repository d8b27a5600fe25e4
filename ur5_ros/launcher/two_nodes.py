"""One run by both nodes, as two processes or as one; the caller needs no ROS."""

import shutil
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from ur5_ros.bag.reader import open_bag
from ur5_ros.config.node_parameters import NodeParameters
from ur5_ros.config.topics import CONTROL_NODE, SIM_NODE
from ur5_ros.errors import InputError
from ur5_ros.launcher.node_processes import END_TIMEOUT, NodeProcesses, lockstep_cores
from ur5_ros.launcher.progress import BagGrowth
from ur5_ros.loop.run_config import RunConfig

#: Wall-clock time without a new state after which a run is given up [s].
START_TIMEOUT = 120.0

#: Process to its module, and to what stands before the parameters of each node in it.
_TWO = {'sim': ('sim_node', {'sim': ''}), 'control': ('control_node', {'control': ''})}
_ONE = {'closed_loop': ('closed_loop', {'sim': f'{SIM_NODE}:', 'control': f'{CONTROL_NODE}:'})}


def run_two_nodes(
    config: RunConfig, folder: Path, progress: Callable[[float], None] = lambda seconds: None,
    composed: bool = False, environments: Sequence[Mapping[str, str]] | None = None,
) -> float:
    """
    Run both nodes until the simulator has reached the end, recording into ``folder``.

    ``config``: parameters of both; ``bag`` is set here; ``folder``: run folder, which exists
    and is empty; ``progress``: gets the simulated time [s] every tenth of a second; ``composed``:
    both in one process; ``environments``: variables of each of two processes, by default as the
    load of this machine asks for.  Returned: wall-clock time from the first state that was
    answered to the last state [s].
    """
    parameters: dict[str, NodeParameters] = {'sim': config.sim, 'control': config.control}
    with tempfile.TemporaryDirectory(prefix='ur5-run-') as logs, \
            NodeProcesses(Path(logs)) as nodes:
        nodes.environment.setdefault('ROS_LOG_DIR', logs)
        processes = _ONE if composed else _TWO
        if environments is None:
            by_load = config.sim.lockstep and not composed
            environments = lockstep_cores() if by_load else [{}, {}]
        if 'UR5_ROS_CORE' in nodes.environment:  # the user's choice
            environments = [{}, {}]
        for (process, (module, prefixes)), more in zip(processes.items(), environments,
                                                       strict=False):
            given = {prefix + key: value for node, prefix in prefixes.items()
                     for key, value in parameters[node].changed_by_name().items()}
            given |= {f'{prefix}bag': str((folder / node).absolute())
                      for node, prefix in prefixes.items()}
            nodes.start(process, f'ur5_ros.nodes.{module}', given, environment=more)
        try:
            _watch(nodes, list(processes), BagGrowth(folder / 'sim'), config, progress)
            for process, (module, _) in processes.items():
                code = nodes.end(process)
                if code != 0:
                    raise InputError(f'{module} ended with code {code}: '
                                     f'{nodes.last_log_line(process)}')
        finally:
            for process in processes:
                shutil.copy(Path(logs) / f'{process}.log', folder)
    times = open_bag(folder / 'sim').columns('/joint_states').log_time
    return float(times[-1] - times[1]) * 1e-9 if len(times) > 2 else 0.0


def _watch(nodes: NodeProcesses, processes: list[str], growth: BagGrowth, config: RunConfig,
           progress: Callable[[float], None]) -> None:
    """Wait for the simulator's end."""
    sim, *others = processes
    moved, states = time.monotonic(), 0
    while nodes.wait(sim, 0.1) is None:
        now = time.monotonic()
        if growth.messages() > states:
            states, moved = growth.messages(), now
            progress(min(states / config.sim.control_rate, config.duration))
        for other in others:
            code = nodes.poll(other)
            if code is not None and nodes.wait(sim, END_TIMEOUT) is None:
                raise InputError(f'{other}_node ended with code {code}: '
                                 f'{nodes.last_log_line(other)}')
        if now - moved > START_TIMEOUT:
            raise InputError(f'no new state for {START_TIMEOUT:g} s; the simulator reports: '
                             f'{nodes.last_log_line(sim)}')
