"""Paced by the wall clock at 1 kHz: late periods, and how long a command takes to come."""

import os
import subprocess
import sys

import numpy as np
from ping_pong import measure
from side_by_side import Row, arguments, publish
from two_nodes_recorded import run

from ur5_ros.loop.plan import plan_run

RATE = 1000
SECONDS = 20.0
REPEATS = 3
#: A period that begins later than this after its time is late [ns].
LATE = 1_000_000

SLEEPER = """
import sys, time
count, period = int(sys.argv[1]), 1e-3
begin = time.monotonic()
for k in range(count):
    rest = begin + k * period - time.monotonic()
    if rest > 0.0:
        time.sleep(rest)
    print(time.monotonic_ns())
"""


def bare_sleep(seconds: float) -> np.ndarray:
    """Return when a loop that does nothing but sleep until each period's time woke [ns]."""
    done = subprocess.run([sys.executable, '-c', SLEEPER, str(round(seconds * RATE))],
                          capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), dtype=np.int64)


def late(times: np.ndarray) -> float:
    """Return the share of periods that began more than 1 ms after their time."""
    schedule = np.arange(len(times)) * (1_000_000_000 // RATE)
    after = times - schedule
    return float((after - np.quantile(after, 0.01) > LATE).mean())


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    seconds, trips, repeats = (3.0, 300, 1) if options.quick else (SECONDS, 5000, options.repeats)
    found: dict[str, list[float]] = {'late': [], 'late sleeper': [], 'p99': [], 'p99 trips': [],
                                     'p99 trips of objects': []}
    plan = plan_run(duration=seconds, sim={'lockstep': False})
    for _ in range(repeats):
        times = run(plan, pinned=False)
        found['late'].append(late(times.states))
        found['p99'].append(float(np.quantile(times.latency, 0.99)) * 1e-9)
        found['late sleeper'].append(late(bare_sleep(seconds)))
        found['p99 trips'].append(measure('wait_set', trips)['p99'])
        found['p99 trips of objects'].append(measure('executor', trips)['p99'])
    median = {name: float(np.median(values)) for name, values in found.items()}
    load = f'; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'
    one = 1.0 / (seconds * RATE)  # no share is below one period
    latency = 'p99 from a state to the arrival of its command'
    publish('paced', 'Paced by the wall clock at 1 kHz', [
        Row('late periods (beyond 1 ms)', 'late periods of a bare sleep loop',
            max(median['late'], one) / max(median['late sleeper'], one), 2.0, False,
            f'{median["late"]:.2%} against {median["late sleeper"]:.2%}' + load),
        Row('share of late periods', '0.1 %', median['late'] / 1e-3, 1.0, False,
            'asks for an idle machine' + load),
        Row(latency, 'p99 of the ping-pong, SingleThreadedExecutor',
            median['p99'] / median['p99 trips of objects'], 2.0, False,
            f'{median["p99"] * 1e6:.0f} us' + load),
        Row(latency, 'p99 of the ping-pong, kept wait set', median['p99'] / median['p99 trips'],
            2.0, False, f'{median["p99"] * 1e6:.0f} us' + load),
    ], {'figures': found}, keep=not options.quick)


if __name__ == '__main__':
    main()
