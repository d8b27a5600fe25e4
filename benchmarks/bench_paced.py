"""Paced by the wall clock at 1 kHz: late periods, and how long a command takes to come."""

import os
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import child
import numpy as np
from ping_pong import measure
from side_by_side import Row, arguments, publish
from two_nodes_recorded import run

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.run_config import RunConfig, run_config

RATE = 1000
SECONDS = 20.0
#: Length of the run whose end is compared with the wall clock [s].
LONG = 30.0
REPEATS = 3
#: A period that begins later than this after its time is late [ns].
LATE = 1_000_000

#: Real-time priority of the runs that have one.
PRIORITY = 80
#: A step on an idle core may take so much longer than the quickest [ns].
STEP = 250_000

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
    done = child.call([sys.executable, '-c', SLEEPER, str(round(seconds * RATE))],
                      capture_output=True, text=True)
    return np.array(done.stdout.split(), dtype=np.int64)


def late(times: np.ndarray) -> float:
    """Return the share of periods that began more than 1 ms after their time."""
    schedule = np.arange(len(times)) * (1_000_000_000 // RATE)
    after = times - schedule
    return float((after - np.quantile(after, 0.01) > LATE).mean())


class Clocks(NamedTuple):
    """A paced run by its own counter and by the times in its bag, which know nothing of it."""

    simulated: float
    """From the first state to the last [s]."""
    wall: float
    """The same by the log times [s]."""
    counted: int
    """Late periods that the node reported on ``/diagnostics``."""
    found: int
    """Periods whose state left more than half a period after its time, by the log times."""
    surely: int
    """Those of them that were late even if their step took :data:`STEP` longer than usual."""
    lost: float
    """By how much the node says that it moved its schedule [s]."""


def clocks(plan: RunConfig) -> Clocks:
    """Run both nodes and read the clocks from the simulator's bag."""
    os.environ['UR5_ROS_CORE'] = ''
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        run_two_nodes(plan, Path(folder))
        bag = open_bag(Path(folder) / 'sim')
        stamp = bag.joint_states('/joint_states').stamp
        log = bag.columns('/joint_states').log_time
        message = [message for _, message in bag.messages('/diagnostics')
                   if message['status'][0]['name'].endswith(': simulator')][-1]
    stamp, first = np.unique(stamp, return_index=True)  # a state may be sent again
    log = log[first]
    reported = {each['key']: each['value'] for each in message['status'][0]['values']}
    time = message['header']['stamp']
    behind = log - stamp
    behind -= np.minimum.accumulate(behind[::-1])[::-1]  # a schedule may only move to later
    then = stamp <= time['sec'] * 1_000_000_000 + time['nanosec']
    return Clocks(float(np.ptp(stamp)) * 1e-9, float(np.ptp(log)) * 1e-9,
                  int(reported['late_periods']), int((behind[then] > 0.5e9 / RATE).sum()),
                  int((behind[then] > 0.5e9 / RATE + STEP).sum()),
                  float(reported['schedule_lost_s']))


def may_schedule() -> bool:
    """Return whether this user may give real-time priorities."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except PermissionError:
        return False
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return True


def with_priority(seconds: float, trips: int, repeats: int) -> dict[str, list[float]]:
    """Return late share, p99 of the loop and p99 of the ping-pong, all with the priority [s]."""
    found: dict[str, list[float]] = {'late': [], 'p99': [], 'p99 trips': []}
    plan = run_config(duration=seconds, sim={'lockstep': False, 'realtime_priority': PRIORITY},
                      control={'realtime_priority': PRIORITY})
    for _ in range(repeats):
        times = run(plan)
        found['late'].append(late(times.states))
        found['p99'].append(float(np.quantile(times.latency, 0.99)) * 1e-9)
        found['p99 trips'].append(measure('wait_set', trips, priority=PRIORITY)['p99'])
    return found


def rows_with_priority(found: dict[str, list[float]], load: str) -> list[Row]:
    """Return the rows of the runs with real-time priority."""
    median = {name: float(np.median(values)) for name, values in found.items()}
    return [
        Row('share of late periods, realtime_priority 80', '0.1 %', median['late'] / 1e-3, 1.0,
            False, f'{median["late"]:.3%}; needs an idle machine' + load),
        Row('p99 from a state to the arrival of its command, realtime_priority 80',
            'p99 of the ping-pong, kept wait set, the same priority',
            median['p99'] / median['p99 trips'], 2.0, False,
            f'{median["p99"] * 1e6:.0f} against {median["p99 trips"] * 1e6:.0f} us' + load)]


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    seconds, trips, repeats = (3.0, 300, 1) if options.quick else (SECONDS, 5000, options.repeats)
    found: dict[str, list[float]] = {'late': [], 'late sleeper': [], 'p99': [], 'p99 trips': [],
                                     'p99 trips of objects': []}
    plan = run_config(duration=seconds, sim={'lockstep': False})
    for _ in range(repeats):
        times = run(plan)
        found['late'].append(late(times.states))
        found['p99'].append(float(np.quantile(times.latency, 0.99)) * 1e-9)
        found['late sleeper'].append(late(bare_sleep(seconds)))
        found['p99 trips'].append(measure('wait_set', trips)['p99'])
        found['p99 trips of objects'].append(measure('executor', trips)['p99'])
    long = clocks(run_config(duration=5.0 if options.quick else LONG, sim={'lockstep': False}))
    prior = with_priority(seconds, trips, repeats) if may_schedule() else None
    median = {name: float(np.median(values)) for name, values in found.items()}
    load = f'; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'
    one = 1.0 / (seconds * RATE)  # no share is below one period
    latency = 'p99 from a state to the arrival of its command'
    publish('paced', 'Paced by the wall clock at 1 kHz', [
        Row('late periods (beyond 1 ms)', 'late periods of a bare sleep loop',
            max(median['late'], one) / max(median['late sleeper'], one), 2.0, False,
            f'{median["late"]:.2%} against {median["late sleeper"]:.2%}' + load),
        Row('share of late periods', '0.1 %', median['late'] / 1e-3, 1.0, False,
            'needs an idle machine' + load),
        Row(latency, 'p99 of the ping-pong, SingleThreadedExecutor',
            median['p99'] / median['p99 trips of objects'], 2.0, False,
            f'{median["p99"] * 1e6:.0f} us' + load),
        Row(latency, 'p99 of the ping-pong, kept wait set', median['p99'] / median['p99 trips'],
            2.0, False, f'{median["p99"] * 1e6:.0f} us' + load),
        Row(f'wall time less simulated time of {long.simulated:.3f} s', '0.1 % of it',
            abs(long.wall - long.simulated) / long.simulated / 1e-3, 1.0, False,
            f'{long.wall:.4f} s, needs a machine without a stall of 0.2 s' + load),
        Row('the same, less what the node reports as lost', '0.1 % of it',
            abs(long.wall - long.lost - long.simulated) / long.simulated / 1e-3, 1.0, False,
            f'{long.lost:.4f} s lost'),
        Row('late periods reported on /diagnostics beyond what the log times of the bag allow',
            'those in the bag, at least 0.1 % of all',
            max(long.surely - long.counted, long.counted - long.found, 0)
            / max(long.found, long.simulated * RATE * 1e-3), 0.1, False,
            f'{long.counted} reported; by the log times {long.surely} to {long.found} began more '
            'than half a period late'),
        *(rows_with_priority(prior, load) if prior else ()),
    ], {'figures': found, 'with priority': prior, 'clocks': long._asdict()},
        keep=not options.quick)
    if prior is None:
        print('Not measured: runs with realtime_priority; this user may not set it')


if __name__ == '__main__':
    main()
