"""Both nodes for a while, and when every message of theirs was sent and heard."""

import os
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.node_processes import NodeProcesses, last_core, lockstep_cores
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.run_config import RunConfig

NODES = {'sim': 'ur5_ros.nodes.sim_node', 'control': 'ur5_ros.nodes.control_node'}


class Times(NamedTuple):
    """Wall-clock times of a run as the simulator recorded them [ns]."""

    states: np.ndarray
    """When each state was sent."""
    latency: np.ndarray
    """From a state to the arrival of its command [ns]."""


#: Where the two nodes run: both on one core, wherever the system likes, each on one of its own.
ONE_CORE = [{'UR5_ROS_CORE': str(last_core())}] * 2
ANY_CORE = [{'UR5_ROS_CORE': ''}] * 2
CORE_EACH = lockstep_cores(0.0)


def run(plan: RunConfig, cores: list[dict[str, str]] | None = None) -> Times:
    """
    Return the times of a run, its first tenth left out: discovery, repeated first states.

    ``cores``: one of the above; as ``ur5 demo`` chooses if not given.
    """
    os.environ.pop('UR5_ROS_CORE', None)
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        run_two_nodes(plan, Path(folder), environments=cores)
        return times_of(Path(folder) / 'sim')


def times_of(folder: Path, prefix: str = '') -> Times:
    """Return the times in a simulator's bag."""
    bag = open_bag(folder)
    sent, stamp = _log(bag, f'{prefix}/joint_states')
    received, answered = _log(bag, f'{prefix}/joint_command')
    _, here, there = np.intersect1d(stamp, answered, return_indices=True)
    begin = len(sent) // 10
    return Times(sent[begin:], (received[there] - sent[here])[begin:])


def per_second(states: np.ndarray) -> float:
    """Return periods a wall-clock second."""
    return float((len(states) - 1) / ((states[-1] - states[0]) * 1e-9))


def arms_at_once(plan: RunConfig, number: int) -> list[Times]:
    """Return the times of several pairs of nodes, each in a namespace, on the same network."""
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as name, \
            NodeProcesses(Path(name)) as nodes:
        nodes.environment.pop('UR5_ROS_CORE', None)
        cores = dict(zip(NODES, lockstep_cores() if number == 1 else ANY_CORE, strict=True))
        folders = [Path(name) / f'arm_{index}' for index in range(number)]
        for folder in folders:
            for node, module in NODES.items():
                given = (plan.sim if node == 'sim' else plan.control).by_name()
                given = {key: value for key, value in given.items() if value != []}
                if node == 'sim':
                    given['publish_clock'] = False
                nodes.start(f'{folder.name}_{node}', module,
                            {**given, 'bag': str(folder / node)}, f'/{folder.name}', cores[node])
        for folder in folders:
            if nodes.wait(f'{folder.name}_sim', 240.0) is None:
                raise SystemExit(f'{folder.name} does not end: '
                                 + nodes.last_log_line(f'{folder.name}_sim'))
        return [times_of(folder / 'sim', f'/{folder.name}') for folder in folders]


def _log(bag, topic: str) -> tuple[np.ndarray, np.ndarray]:
    """Return log times and stamps [ns] of a JointState topic, in the order of the log."""
    log, stamp = bag.columns(topic).log_time, bag.joint_states(topic).stamp
    order = np.argsort(log, kind='stable')
    return log[order], stamp[order]
