"""The closed loop of two nodes against what the middleware allows, measured side by side."""

import os
import tempfile
from pathlib import Path

import numpy as np
from ping_pong import measure
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.node_processes import last_core, shared_core
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.run_config import run_config

TRIPS = 5000
REPEATS = 5


def lockstep(seconds: float, control_rate: int = 1000, pinned: bool = True,
             composed: bool = False) -> float:
    """Return periods a wall-clock second of a run of the paper's experiment, recording on."""
    if pinned:
        os.environ['UR5_ROS_CORE'] = str(last_core())
    else:
        os.environ['UR5_ROS_CORE'] = ''
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        run_two_nodes(run_config(duration=seconds, control_rate=control_rate), Path(folder),
                      composed=composed)
        times = np.sort(open_bag(Path(folder) / 'sim').columns('/joint_states').log_time)
    times = times[len(times) // 10:]  # discovery and the resent copies of state 1
    return float((len(times) - 1) / ((times[-1] - times[0]) * 1e-9))


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    seconds, trips = (2.0, 300) if options.quick else (10.0, TRIPS)
    core, shared = last_core(), shared_core()
    figures = interleave({
        'loop': lambda: lockstep(seconds),
        'loop on two cores': lambda: lockstep(seconds, pinned=False),
        'one process': lambda: lockstep(seconds, pinned=False, composed=True),
        'executor': lambda: measure('executor', trips)['per_second'],
        'wait set': lambda: measure('wait_set', trips)['per_second'],
        'wait set on one core': lambda: measure('wait_set', trips, core)['per_second'],
        'wait set, shared memory': lambda: measure(
            'wait_set', trips, transports='default')['per_second'],
    }, 1 if options.quick else options.repeats)
    loop = 'lockstep periods a second, recording on'
    detail = 'both nodes on one core; ping-pong over the same transport, reliable, keep last 1'
    median = {name: float(np.median(values)) for name, values in figures.items()}
    faster = 'loop' if median['loop'] >= median['loop on two cores'] else 'loop on two cores'
    publish('lockstep', "The loop of two nodes (1 kHz, the paper's experiment)", [
        Row(loop, 'ping-pong, SingleThreadedExecutor, two cores (its best)',
            ratio(figures, 'loop', 'executor'), 1.2, True, detail),
        Row(loop, 'ping-pong, kept wait set, one core',
            ratio(figures, 'loop', 'wait set on one core'), 0.75, True, detail),
        Row(loop, 'ping-pong, kept wait set, two cores',
            ratio(figures, 'loop', 'wait set'), 0.75, True, detail),
        Row(loop, "ping-pong, kept wait set, two cores, Fast DDS's default transports",
            ratio(figures, 'loop', 'wait set, shared memory'), 0.75, True,
            'shared memory, which the nodes do without: docs/decisions/loopback.md'),
        Row(loop + ', two cores', 'ping-pong, kept wait set, two cores',
            ratio(figures, 'loop on two cores', 'wait set'), 0.75, True, 'not pinned'),
        Row(loop + ', two cores', 'ping-pong, SingleThreadedExecutor, two cores',
            ratio(figures, 'loop on two cores', 'executor'), 1.2, True, 'not pinned'),
        Row('both nodes in one process: periods a second, recording on',
            'two processes, pinned or not, whichever is faster',
            ratio(figures, 'one process', faster), 1.4, True, '`ur5 demo --composed`'),
        Row('simulated time per wall time at 1 kHz, `ur5 demo --composed`', 'real time',
            median['one process'] / 1000.0, 8.0, True,
            f'where the ping-pong takes {1e6 / median["wait set"]:.0f} us on two cores'),
        Row('simulated time per wall time at 1 kHz, as `ur5 demo` runs', 'real time',
            median['loop' if shared else 'loop on two cores'] / 1000.0, 3.0, True,
            ('one core, as the machine is quiet' if shared else 'two cores, as others compute too')
            + f'; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'),
    ], {'per_second': figures, 'medians': median}, keep=not options.quick)


if __name__ == '__main__':
    main()
