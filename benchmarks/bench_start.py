"""How long the nodes take to start, against the least that any rclpy node needs."""

import os
import re
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import child
import numpy as np
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.node_processes import NodeProcesses, private_environment

REPEATS = 7
TIMEOUT = 60.0
LEAST = """
import time
import rclpy
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node('least')
node.create_publisher(JointState, 'joint_states', 1).publish(JointState())
print(time.time_ns(), flush=True)
import os
os._exit(0)
"""
STAMP = re.compile(r'\[(\d+\.\d+)\] \[ur5_control\]: waiting for states')


def least() -> float:
    """Return the time from the start to the first message of a node that does nothing [s]."""
    begin = time.time_ns()
    done = child.call([sys.executable, '-c', LEAST], capture_output=True, text=True,
                      env=private_environment())
    return (int(done.stdout) - begin) * 1e-9


def simulator(lockstep: bool = True) -> float:
    """Return the time from the start of sim_node to its first state, its last one too [s]."""
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder, \
            NodeProcesses(Path(folder)) as nodes:
        begin = time.time_ns()
        nodes.start('sim', 'ur5_ros.nodes.sim_node', {
            'bag': f'{folder}/bag', 'lockstep': lockstep, 'stop_after': 0.001})
        if nodes.wait('sim', TIMEOUT) is None:
            raise SystemExit('sim_node does not end: ' + nodes.last_log_line('sim'))
        first = open_bag(Path(folder) / 'bag').columns('/joint_states').log_time.min()
    return float(first - begin) * 1e-9


def controller() -> float:
    """Return the time from the start of control_node until it waits for states [s]."""
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder, \
            NodeProcesses(Path(folder)) as nodes:
        begin, limit = time.time(), time.monotonic() + TIMEOUT
        nodes.start('control', 'ur5_ros.nodes.control_node', {
            'bag': '', 'experiment': 'kebria_fig11'})
        while time.monotonic() < limit:
            printed = STAMP.search((Path(folder) / 'control.log').read_text())
            if printed:
                return float(printed.group(1)) - begin
            time.sleep(0.02)
        raise SystemExit('control_node does not start: ' + nodes.last_log_line('control'))


def processor_time(measure: Callable[[], float], spent: list[float]) -> Callable[[], float]:
    """Return ``measure``, noting what its children took until their end, ours closed bags too."""
    def measured() -> float:
        before = os.times()
        figure = measure()
        after = os.times()
        spent.append(after.children_user + after.children_system
                     - before.children_user - before.children_system)
        return figure
    return measured


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    measures = {'sim_node': simulator, 'paced': lambda: simulator(lockstep=False),
                'control_node': controller, 'least': least}
    spent: dict[str, list[float]] = {name: [] for name in measures}
    candidates = {name: processor_time(measure, spent[name]) for name, measure in measures.items()}
    if not options.quick:
        interleave(candidates, 1)  # warms the disk cache
    figures = interleave(candidates, 1 if options.quick else options.repeats)
    median = {name: float(np.median(values)) for name, values in figures.items()}
    cpu = {name: float(np.median(values)) for name, values in spent.items()}
    reference = 'import rclpy, create_node, first publish'
    publish('start', 'Start-up of a node, warm cache', [
        Row('sim_node, from its start to its first state', reference,
            ratio(figures, 'sim_node', 'least'), 2.0, False,
            f'{median["sim_node"]:.2f} s against {median["least"]:.2f} s; processor time '
            f'to its end {cpu["sim_node"]:.2f} s against {cpu["least"]:.2f} s'),
        Row('the same, paced by the wall clock', reference, ratio(figures, 'paced', 'least'), 3.5,
            False, f'{median["paced"]:.2f} s; processor time to its end {cpu["paced"]:.2f} s; '
            'loads numba and compiled code before its time runs'),
        Row('control_node, from its start until it waits for states', reference,
            ratio(figures, 'control_node', 'least'), 3.5, False,
            f'{median["control_node"]:.2f} s; processor time to its end '
            f'{cpu["control_node"]:.2f} s; loads numba and compiled code'),
    ], {'seconds': figures, 'processor_seconds': spent}, keep=not options.quick)


if __name__ == '__main__':
    main()
