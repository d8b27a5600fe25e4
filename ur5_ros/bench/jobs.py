"""The jobs of the bench spread over Dask workers, a row for each."""

from collections.abc import Callable
from typing import Any

from ur5_ros.bench.limited_job import limited_row
from ur5_ros.bench.runs import Job, lost_row, overflow_ignored, row_of
from ur5_ros.errors import InputError
from ur5_ros.sweep.workers import cluster, connected, map_batches


def run_jobs(jobs: list[Job], scheduler: str | None = None, workers: int | None = None,
             progress: Callable[[float], None] = lambda done: None) -> list[dict[str, Any]]:
    """
    Return a row for each job, in their order.

    ``scheduler``: address of a Dask scheduler; workers on this machine if not given; ``workers``:
    worker processes on this machine; one a core if not given.
    """
    rows: list[dict[str, Any]] = []
    with cluster(scheduler, workers) as address, connected(address) as client:
        for some in map_batches(client, do_jobs, (), iter(enumerate(jobs)), 1, _failed):
            rows += some
            progress(len(rows))
    if len(rows) < len(jobs):
        raise InputError(f'the scheduler was lost after {len(rows)} of {len(jobs)} runs; start '
                         'again')
    return sorted(rows, key=lambda row: row['index'])


def do_jobs(jobs: list[tuple[int, Job]]) -> list[dict[str, Any]]:
    """
    Return the rows of some jobs: the task that travels to a worker.

    A law of a user's file runs in a process of its own: whatever it does, the bench goes on.
    """
    with overflow_ignored():
        return [_head(index, job) | (limited_row(job) if job.entry.timeout else row_of(job))
                for index, job in jobs]


def _head(index: int, job: Job) -> dict[str, Any]:
    return {'index': index, 'law': job.entry.name, 'perturbation': job.perturbation,
            'seed': job.seed, 'kind': 'survival' if job.survival else 'run'}


def _failed(item: tuple[int, Job], error: BaseException) -> dict[str, Any]:
    """Return the row of a job whose worker died."""
    return _head(*item) | lost_row(item[1], f'its worker failed: {error!r}')
