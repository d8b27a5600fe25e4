"""The runs of a sweep on Dask workers: the cores here, or a cluster that is there already."""

import asyncio
import logging
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, as_completed

from ur5_ros.errors import Refusal
from ur5_ros.loop.sweep_run import inputs_of, row_of
from ur5_ros.loop.sweep_spec import RunSpec, SweepSpec, expand, number_of_runs
from ur5_ros.loop.sweep_table import SweepFolder

#: Wall-clock time that a scheduler gets to answer [s].
PATIENCE = 8.0

#: Wall-clock time that a scheduler which went away gets to come back [s].
RETURN_TIME = 60.0

#: Tasks under way for each worker thread: one runs, the others wait beside it.
AHEAD = 3

#: Control periods in one task, so that a task takes some seconds.
PERIODS_IN_TASK = 40_000

_MOST_IN_TASK = 200
_LOST = ('cancelled', 'lost')


def run_sweep(
    spec: SweepSpec, folder: SweepFolder, scheduler: str | None = None,
    workers: int | None = None, progress: Callable[[float], None] = lambda done: None,
) -> None:
    """
    Run what a sweep folder still lacks.

    Parameters
    ----------
    spec : SweepSpec
        The sweep.
    folder : SweepFolder
        Where rows go; the runs whose rows are there are not run again.
    scheduler : str, optional
        Address of a Dask scheduler; workers on this machine if not given.
    workers : int, optional
        Worker processes on this machine; one a core if not given.
    progress : callable, optional
        Is told the number of rows that are there.

    Raises
    ------
    Refusal
        If nobody answers at the address, or a scheduler that went away does not come back.

    """
    done = folder.done()
    progress(len(done))
    if len(done) == number_of_runs(spec):
        return
    bags = (folder.path / 'bags').absolute() if spec.keep != 'none' else None
    with _cluster(scheduler, workers) as address:
        while len(done) < number_of_runs(spec):
            with _client(address) as client:
                for rows in _rows(client, spec, done, bags):
                    folder.add(rows)
                    done.update(row['index'] for row in rows)
                    progress(len(done))


def batch_size(spec: SweepSpec) -> int:
    """Return how many runs make one task."""
    periods = (spec.duration or 20.0) * 1000
    return max(1, min(_MOST_IN_TASK, round(PERIODS_IN_TASK / periods)))


def run_batch(spec: SweepSpec, runs: list[RunSpec], bags: str | None) -> list[dict[str, Any]]:
    """Return the rows of some runs: the task that travels to a worker."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')  # a run that diverges overflows; its row says so
        return [row_of(spec, run, Path(bags) if bags else None) for run in runs]


def _rows(client: Client, spec: SweepSpec, done: set[int],
          bags: Path | None) -> Iterator[list[dict[str, Any]]]:
    """Yield rows as tasks end; return early, with runs left, when the scheduler is lost."""
    todo = (run for run in expand(spec) if run.index not in done)
    under_way: dict[Future, list[RunSpec]] = {}
    size = 1 if spec.engine == 'nodes' else batch_size(spec)
    shared = client.scatter(spec, broadcast=True, hash=False)

    def submit(runs: list[RunSpec]) -> Future:
        future = client.submit(run_batch, shared, runs, str(bags) if bags else None, pure=False)
        under_way[future] = runs
        return future

    threads = max(1, sum(client.nthreads().values()))
    futures = [submit(batch) for _ in range(AHEAD * threads)
               if (batch := list(islice(todo, size)))]
    ended = as_completed(futures, loop=client.loop)
    for future in ended:
        runs = under_way.pop(future)
        if future.status in _LOST:
            return
        error = future.exception()
        if error is None:
            yield future.result()
        elif len(runs) > 1:  # find out which of them it was
            for run in runs:
                ended.add(submit([run]))
        else:
            yield [_lost_row(run, error) for run in runs]
        batch = list(islice(todo, size))
        if batch:
            ended.add(submit(batch))


def _lost_row(run: RunSpec, error: BaseException) -> dict[str, Any]:
    what = 'its worker died each time' if isinstance(error, KilledWorker) else repr(error)
    return inputs_of(run) | {'status': 'failed', 'success': False, 'why': what}


@contextmanager
def _cluster(scheduler: str | None, workers: int | None) -> Iterator[str]:
    """Yield the address of a scheduler; that of workers on this machine if none is given."""
    logging.getLogger('distributed').setLevel(logging.CRITICAL)
    if scheduler is not None:
        yield scheduler
        return
    number = workers if workers is not None else len(os.sched_getaffinity(0))
    if number < 1:
        raise Refusal(f'--workers {number}; give at least 1')
    with dask.config.set({'distributed.worker.daemon': True,
                          'distributed.admin.large-graph-warning-threshold': '1GB'}), \
            LocalCluster(n_workers=number, threads_per_worker=1, processes=True,
                         dashboard_address=None, silence_logs=logging.CRITICAL) as cluster:
        yield cluster.scheduler_address


@contextmanager
def _client(address: str) -> Iterator[Client]:
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, asyncio.TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refusal(f'no Dask scheduler answers at {address} ({reason}); start one with '
                      '"dask scheduler", or leave --scheduler out') from None
    try:
        yield client
    finally:
        client.close(timeout=2)
