"""Sweeps: runs of each kind against PyBullet's bare loop, and two workers against one."""

import os

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')  # as Dask does for its workers
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from bench_loop_without_ros import BareLoop
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.loop.rollout import rollout
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.kernels.compiled import limit_threads
from ur5_ros.sweep.engine import run_sweep
from ur5_ros.sweep.run import row_of
from ur5_ros.sweep.spec import expand, parse_sweep
from ur5_ros.sweep.table import SweepFolder
from ur5_ros.sweep.workers import cluster

REPEATS = 5
RUNS = 400
DURATION = 2.0
PERIODS = round(DURATION * 1000)

#: Name, further lines of the specification, and the bar where there is one.
KINDS = {
    'an ordinary run': ('judge: metrics', 0.5),
    'an ordinary run, judged by all checks': ('judge: checks', 0.35),
    'with commands 2 periods late': (
        'judge: metrics\nfixed: {sim.delay.command_periods: 2}', 0.5),
    'with encoder noise': ('judge: metrics\nfixed: {sim.noise.position: 1.0e-5}', 0.4),
    'with rotor inertia': ('judge: metrics\nfixed: {arm: ur5_real, control_arm: ur5_real}', 0.3),
    'with viscous friction': (
        'judge: metrics\nfixed: {sim.friction.viscous: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]}', 0.3),
    'with dry friction': (
        'judge: metrics\nfixed: {sim.friction.coulomb: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]}', 0.3),
}


def specification(name: str, lines: str, runs: int = 1) -> str:
    """Return a sweep with random starts."""
    return (f'name: {name}\nduration: {DURATION}\nseed: 1\nsamples: {runs}\n'
            f'success: {{max_error: 1.0}}\n{lines}\n'
            'vary:\n  initial_error: {uniform: [-0.05, 0.05], size: 6}\n')


def rate_of(lines: str) -> Callable[[], float]:
    """Return what measures periods a second of processor time of one run, its row included."""
    spec = parse_sweep(specification('kind', lines), 'bench')
    run, = expand(spec)
    row_of(spec, run, None)  # compiles, plans, opens the world

    def measure() -> float:
        begin = time.process_time()
        row_of(spec, run, None)
        return PERIODS / (time.process_time() - begin)

    return measure


def bare_rate() -> Callable[[], float]:
    """Return what measures the same of set, step, read."""
    plan = run_config(duration=DURATION)
    bare = BareLoop(plan, rollout(plan).torque[:, 0])

    def measure() -> float:
        begin = time.process_time()
        bare.periods_per_second()
        return PERIODS / (time.process_time() - begin)

    return measure


class Workers:
    """
    A cluster that stays, and sweeps on it.

    Parameters
    ----------
    address : str
        Of its scheduler.
    folder : pathlib.Path
        For the tables.
    runs : int
        Runs of a sweep.

    """

    def __init__(self, address: str, folder: Path, runs: int):
        self._address, self._folder, self._runs, self._number = address, folder, runs, 0

    def runs_per_second(self) -> float:
        """Run a sweep from its specification to its last row; return runs a second."""
        self._number += 1
        spec = parse_sweep(specification('workers', 'judge: metrics', self._runs), 'bench')
        folder = SweepFolder(self._folder / str(self._number), spec)
        begin = time.perf_counter()
        run_sweep(spec, folder, self._address)
        return self._runs / (time.perf_counter() - begin)


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    repeats, runs = (1, 2) if options.quick else (options.repeats, RUNS)
    limit_threads(1)  # as a worker does
    rates = {name: rate_of(lines) for name, (lines, _) in KINDS.items()}
    figures = interleave({'bare': bare_rate(), **rates}, 1 if options.quick else 3 * repeats)
    with tempfile.TemporaryDirectory(prefix='ur5-bench-sweep-') as folder, \
            cluster(workers=1) as one, cluster(workers=2) as two:
        workers = {'one': Workers(one, Path(folder) / 'one', runs),
                   'two': Workers(two, Path(folder) / 'two', runs)}
        for each in workers.values():
            each.runs_per_second()  # imports, compiles
        wall = interleave({name: each.runs_per_second for name, each in workers.items()}, repeats)
    load = f'load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'
    median = {name: float(np.median(values)) for name, values in (figures | wall).items()}
    reference = 'bare PyBullet set-step-read loop, processor time'
    publish('sweep', 'Runs of a sweep of 2 s at 1 kHz, from specification to row', [
        *(Row(name, reference, ratio(figures, name, 'bare'), bar, True,
              f'{median[name]:.0f} periods a second') for name, (_, bar) in KINDS.items()),
        Row('two workers', 'one worker, wall time', ratio(wall, 'two', 'one'), 1.8, True,
            f'{median["two"]:.1f} against {median["one"]:.1f} runs a second; {load}'),
    ], {'figures': figures | wall},
        keep=not options.quick)


if __name__ == '__main__':
    main()
