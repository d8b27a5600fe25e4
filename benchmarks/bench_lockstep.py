"""The closed loop of two nodes against what the middleware allows, measured side by side."""

import os
import tempfile
from pathlib import Path

import numpy as np
from ping_pong import measure
from side_by_side import Row, arguments, interleave, publish, ratio
from two_nodes_recorded import ANY_CORE, CORE_EACH, ONE_CORE

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.node_processes import last_core, lockstep_cores
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.run_config import run_config

TRIPS = 5000
REPEATS = 5


def lockstep(seconds: float, control_rate: int = 1000,
             cores: list[dict[str, str]] | None = None) -> float:
    """
    Return periods a wall-clock second of a run of the paper's experiment, recording on.

    ``cores``: where two processes run; both nodes in one process if not given.
    """
    os.environ.pop('UR5_ROS_CORE', None)
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        run_two_nodes(run_config(duration=seconds, control_rate=control_rate), Path(folder),
                      composed=cores is None, environments=cores)
        times = np.sort(open_bag(Path(folder) / 'sim').columns('/joint_states').log_time)
    times = times[len(times) // 10:]  # discovery and the resent copies of state 1
    return float((len(times) - 1) / ((times[-1] - times[0]) * 1e-9))


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    seconds, trips = (0.5, 100) if options.quick else (10.0, TRIPS)
    core, quiet = last_core(), lockstep_cores() == CORE_EACH
    figures = interleave({
        'loop, a core each': lambda: lockstep(seconds, cores=CORE_EACH),
        'loop on one core': lambda: lockstep(seconds, cores=ONE_CORE),
        'loop on any core': lambda: lockstep(seconds, cores=ANY_CORE),
        'one process': lambda: lockstep(seconds),
        'executor': lambda: measure('executor', trips)['per_second'],
        'wait set': lambda: measure('wait_set', trips)['per_second'],
        'wait set on one core': lambda: measure('wait_set', trips, core)['per_second'],
        'wait set, shared memory': lambda: measure(
            'wait_set', trips, transports='default')['per_second'],
    }, 1 if options.quick else options.repeats)
    loop = 'lockstep periods a second, recording on'
    each, one, any_ = (f'{loop}, {where}' for where in ('a core each', 'one core', 'any core'))
    trip = 'ping-pong over the same transport, reliable, keep last 1'
    median = {name: float(np.median(values)) for name, values in figures.items()}
    faster = max(('loop, a core each', 'loop on one core', 'loop on any core'), key=median.get)
    publish('lockstep', "The loop of two nodes (1 kHz, the paper's experiment)", [
        Row(each, 'ping-pong, kept wait set, one core (its best)',
            ratio(figures, 'loop, a core each', 'wait set on one core'), 0.6, True,
            f'as `ur5 demo` runs on a quiet machine; {trip}'),
        Row(each, 'ping-pong, kept wait set, two cores',
            ratio(figures, 'loop, a core each', 'wait set'), 0.75, True, trip),
        Row(each, "ping-pong, kept wait set, two cores, Fast DDS's default transports",
            ratio(figures, 'loop, a core each', 'wait set, shared memory'), 0.75, True,
            'shared memory, which the nodes do without: docs/decisions/loopback.md'),
        Row(each, 'ping-pong, SingleThreadedExecutor, two cores (its best)',
            ratio(figures, 'loop, a core each', 'executor'), 1.2, True, trip),
        Row(one, 'ping-pong, kept wait set, one core',
            ratio(figures, 'loop on one core', 'wait set on one core'), 0.6, True,
            'both nodes and all of their threads on it'),
        Row(any_, 'ping-pong, kept wait set, two cores',
            ratio(figures, 'loop on any core', 'wait set'), 0.75, True,
            'as `ur5 demo` runs where others compute too'),
        Row('both nodes in one process: periods a second, recording on',
            'two processes, whichever of these is the fastest',
            ratio(figures, 'one process', faster), 1.4, True, '`ur5 demo --composed`'),
        Row('simulated time per wall time at 1 kHz, `ur5 demo --composed`', 'real time',
            median['one process'] / 1000.0, 8.0, True,
            f'where the ping-pong takes {1e6 / median["wait set"]:.0f} us on two cores'),
        Row('simulated time per wall time at 1 kHz, as `ur5 demo` runs', 'real time',
            median['loop, a core each' if quiet else 'loop on any core'] / 1000.0, 3.0, True,
            ('a core each, as the machine is quiet' if quiet else
             'any core, as others compute too')
            + f'; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'),
    ], {'per_second': figures, 'medians': median}, keep=not options.quick)


if __name__ == '__main__':
    main()
