"""The runs of a sweep, done by Dask workers until every row is there."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from distributed import KilledWorker

from ur5_ros.errors import InputError
from ur5_ros.sweep.provenance import check_provenance, check_worker, sources
from ur5_ros.sweep.run import inputs_of, row_of
from ur5_ros.sweep.spec import RunSpec, SweepSpec, expand, number_of_runs
from ur5_ros.sweep.table import SweepFolder
from ur5_ros.sweep.workers import RETRY_TIMEOUT, WORKER_TIMEOUT, cluster, connected, map_batches

#: Control periods in one task, so that a task takes some seconds.
PERIODS_PER_TASK = 40_000

_MOST_RUNS_PER_TASK = 200


def run_sweep(
    spec: SweepSpec, folder: SweepFolder, scheduler: str | None = None,
    workers: int | None = None, progress: Callable[[float], None] = lambda done: None,
) -> None:
    """
    Run what a sweep folder still lacks.

    ``folder``: where rows go; the runs whose rows are there are not run again; ``scheduler``:
    address of a Dask scheduler; workers on this machine if not given; ``workers``: worker
    processes on this machine; one a core if not given.
    """
    with folder.lock():
        _run_the_rest(spec, folder, scheduler, workers, progress)


def _run_the_rest(
    spec: SweepSpec, folder: SweepFolder, scheduler: str | None, workers: int | None,
    progress: Callable[[float], None],
) -> None:
    done = folder.done()
    progress(len(done))
    if len(done) == number_of_runs(spec):
        return
    check_provenance(folder.path, len(done))
    bags = str((folder.path / 'bags').absolute()) if spec.keep != 'none' else None
    shared = (spec, bags, sources())
    timeout = WORKER_TIMEOUT
    with cluster(scheduler, workers) as address:
        while len(done) < number_of_runs(spec):
            todo = (run for run in expand(spec) if run.number not in done)
            with connected(address, timeout) as client:
                timeout = RETRY_TIMEOUT
                for rows in map_batches(client, run_batch, shared, todo, batch_size(spec),
                                        lost_row):
                    folder.add(rows)
                    done.update(row['index'] for row in rows)
                    progress(len(done))


def batch_size(spec: SweepSpec) -> int:
    """Return how many runs make one task."""
    if spec.engine == 'nodes':
        return 1
    periods = (spec.duration or 20.0) * 1000
    return max(1, min(_MOST_RUNS_PER_TASK, round(PERIODS_PER_TASK / periods)))


def run_batch(spec: SweepSpec, bags: str | None, code: str,
              runs: list[RunSpec]) -> list[dict[str, Any]]:
    """Return the rows of some runs: the task that travels to a worker."""
    check_worker(code)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')  # a run that diverges overflows; its row records it
        return [row_of(spec, run, Path(bags) if bags else None) for run in runs]


def lost_row(run: RunSpec, error: BaseException) -> dict[str, Any]:
    """Return the row of a run that could not be done; a worker that is refused ends the sweep."""
    if isinstance(error, InputError):
        raise error
    what = 'its worker died each time' if isinstance(error, KilledWorker) else repr(error)
    return inputs_of(run) | {'status': 'failed', 'success': False, 'why': what}
