"""The bench of the laws, whole: two workers against one, and against ten minutes."""

import os
import time
from collections.abc import Callable

from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.bench.entries import load_entries
from ur5_ros.bench.perturbations import PERTURBATIONS, QUICK
from ur5_ros.bench.runs import jobs_of, run_jobs

REPEATS = 1
SEEDS = 5
#: Longest that the bench may take on two cores [s].
LONGEST = 600.0


def seconds(workers: int, seeds: int, quick: bool) -> Callable[[], float]:
    """Return what measures a bench from the start of its workers to its last row [s]."""
    entries = load_entries()
    jobs = jobs_of(entries[:2] if quick else entries, QUICK if quick else PERTURBATIONS, seeds,
                   survival=not quick)

    def measure() -> float:
        begin = time.perf_counter()
        rows = run_jobs(jobs, workers=workers)
        assert len(rows) == len(jobs)
        return time.perf_counter() - begin

    return measure


def main() -> None:
    """Measure and keep the table."""
    parser = arguments(__doc__, REPEATS)
    parser.add_argument('--seeds', type=int, default=SEEDS, help='of each perturbation')
    options = parser.parse_args()
    seeds = 1 if options.quick else options.seeds
    wall = interleave({'two': seconds(2, seeds, options.quick),
                       'one': seconds(1, seeds, options.quick)}, options.repeats)
    rows = [Row('two workers', 'one worker, wall time', ratio(wall, 'one', 'two'), 1.8, True,
                f'{min(wall["two"]):.0f} s against {min(wall["one"]):.0f} s, {seeds} seeds; load '
                f'{os.getloadavg()[0]:.1f} on {os.cpu_count()} cores')]
    if seeds >= SEEDS:
        rows.append(Row('the bench on two workers', 'ten minutes', min(wall['two']) / LONGEST,
                        1.0, False, f'{min(wall["two"]):.0f} s'))
    publish('laws', 'Eleven laws under eight perturbations, from the start of the workers',
            rows, {'wall': wall}, keep=not options.quick)


if __name__ == '__main__':
    main()
