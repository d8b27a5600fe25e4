"""The bench of the laws: two workers against one; with ``--whole`` all of it, in ten minutes."""

import os
import time

from side_by_side import Row, arguments, interleave, publish, ratio, realtime

from ur5_ros.bench.entries import load_entries
from ur5_ros.bench.jobs import run_jobs
from ur5_ros.bench.perturbations import PERTURBATIONS, QUICK
from ur5_ros.bench.runs import Job, jobs_of

REPEATS = 1
#: Seeds of the whole bench, and of its runs that are measured on one worker and on two.
WHOLE, PART = 5, 3
#: Longest that the whole may take on two cores [s].
LONGEST = 600.0


def seconds(jobs: list[Job], workers: int) -> float:
    """Return how long jobs take, from the start of the workers to the last row [s]."""
    begin = time.perf_counter()
    assert len(run_jobs(jobs, workers=workers)) == len(jobs)
    return time.perf_counter() - begin


def whole() -> None:
    """Measure all that ``ur5 bench`` does, on two workers."""
    jobs = jobs_of(load_entries(), PERTURBATIONS, WHOLE)
    taken = seconds(jobs, 2)
    publish('laws_whole', f'Eleven laws, eight perturbations, {WHOLE} seeds and the bisections', [
        Row('ur5 bench on two workers', 'ten minutes', taken / LONGEST, 1.0, False,
            f'{len(jobs)} jobs in {taken:.0f} s; {load()}')])


def part(quick: bool, repeats: int) -> None:
    """Measure two workers against one."""
    entries = load_entries()
    jobs = (jobs_of(entries[:2], QUICK, 1, survival=False) if quick else
            jobs_of(entries, PERTURBATIONS, PART, survival=False))
    wall = interleave({'two': lambda: seconds(jobs, 2), 'one': lambda: seconds(jobs, 1)}, repeats)
    publish('laws', f'Runs of the bench: eleven laws, eight perturbations, {PART} seeds', [
        Row('two workers', 'one worker, wall time', ratio(wall, 'one', 'two'), 1.8, True,
            f'{len(jobs)} runs in {min(wall["two"]):.0f} s against {min(wall["one"]):.0f} s; '
            f'{load()}')], {'wall': wall}, keep=not quick)


def load() -> str:
    """Return how busy the machine is, and the class in which this process is scheduled."""
    return (f'load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'
            + (', real-time priority' if realtime() else ''))


def main() -> None:
    """Measure and keep the table."""
    parser = arguments(__doc__, REPEATS)
    parser.add_argument('--whole', action='store_true', help='all that ur5 bench does, once')
    options = parser.parse_args()
    if options.whole and not options.quick:
        whole()
    else:
        part(options.quick, options.repeats)


if __name__ == '__main__':
    main()
