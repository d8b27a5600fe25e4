"""Work spread over Dask workers: the cores here, or a cluster that is there already."""

import asyncio
import logging
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import islice
from multiprocessing import resource_tracker
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

import dask
from distributed import Client, Future, LocalCluster, as_completed
from distributed.comm import connect
from distributed.security import Security

from ur5_ros.errors import InputError
from ur5_ros.launcher.signals import held_back, interrupted_by_sigterm
from ur5_ros.model.kernels.compiled import limit_threads

#: Wall-clock time that a scheduler gets to answer [s].
WORKER_TIMEOUT = 5.0

#: The same for one that was there before, and may be starting again [s].
RETRY_TIMEOUT = 60.0

#: Tasks under way for each worker thread: one runs, the others wait beside it.
TASKS_PER_THREAD = 3

_LOST_STATUS = ('cancelled', 'lost')

Item = TypeVar('Item')
Result = TypeVar('Result')


@contextmanager
def cluster(scheduler: str | None = None, workers: int | None = None) -> Iterator[str]:
    """
    Yield the address of a Dask scheduler.

    ``scheduler``: address of one that runs already; worker processes here are started if not
    given; ``workers``: how many of them; one a core if not given.
    """
    _silence()
    with interrupted_by_sigterm():
        if scheduler is not None:
            yield scheduler
        else:
            with _workers(workers) as address:
                yield address


@contextmanager
def _workers(workers: int | None) -> Iterator[str]:
    """Start worker processes here and yield the address of their scheduler."""
    number = workers if workers is not None else len(os.sched_getaffinity(0))
    if number < 1:
        raise InputError(f'--workers {number}; give at least 1')
    # Dask's profiler looks at the stacks a hundred times a second and keeps an hour of them.
    with TemporaryDirectory(prefix='ur5-sweep-', ignore_cleanup_errors=True) as scratch, \
            dask.config.set({'temporary-directory': scratch,
                             'distributed.worker.daemon': True,
                             'distributed.worker.profile.enabled': False}):
        # Begun later, the tracker of shared memory would let the cluster's thread take Ctrl-C.
        resource_tracker.ensure_running()
        with ExitStack() as started:
            with held_back():  # a cluster that is half made could not be ended
                local = started.enter_context(LocalCluster(
                    n_workers=number, threads_per_worker=1, processes=True,
                    dashboard_address='127.0.0.1:0', silence_logs=logging.CRITICAL))
            yield local.scheduler_address


@contextmanager
def connected(address: str, timeout: float = WORKER_TIMEOUT) -> Iterator[Client]:
    """
    Yield a client of the scheduler at an address.

    ``address``: such as ``tcp://host:8786``; ``timeout``: wall-clock time that it gets to answer
    [s].
    """
    try:
        kind = asyncio.run(asyncio.wait_for(_kind(address, timeout), timeout))
    except Exception as error:  # another program may answer with anything
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f'no Dask scheduler answers at {address} ({reason}); start one with '
                         '"dask scheduler", or leave --scheduler out') from None
    if kind != 'Scheduler':
        raise InputError(f'a Dask {kind} answers at {address}; give the address of its scheduler')
    client = Client(address, timeout=timeout, set_as_default=False)
    try:
        yield client
    finally:
        with suppress(Exception):  # of a client that was just looking for its scheduler again
            client.close(timeout=2)


def map_batches(
    client: Client, function: Callable[..., list[Result]], shared: tuple[Any, ...],
    items: Iterator[Item], size: int, failed: Callable[[Item, BaseException], Result],
) -> Iterator[list[Result]]:
    """
    Apply a function to items, some at a time, and yield the results as they come.

    A task that fails is taken apart, so that one item costs no other its result.

    ``function``: ``function(*shared, items)`` returns one result an item; ``shared``: what every
    task needs; small, as it travels with each; ``items``: what there is to do; read as the work
    goes on.  Returned: results in any order; ends early, with work left, when the scheduler is
    lost.
    """
    under_way: dict[Future, list[Item]] = {}

    def submit(batch: list[Item]) -> Future:
        future = client.submit(_on_one_thread, function, *shared, batch, pure=False)
        under_way[future] = batch
        return future

    threads = max(1, sum(client.nthreads().values()))
    first = [submit(batch) for _ in range(TASKS_PER_THREAD * threads)
             if (batch := list(islice(items, size)))]
    ended = as_completed(first, loop=client.loop)
    for future in ended:
        batch = under_way.pop(future)
        if future.status in _LOST_STATUS:
            return
        error = future.exception()
        if error is None:
            yield future.result()
        elif len(batch) > 1:  # find out which of them it was
            for item in batch:
                ended.add(submit([item]))
        else:
            yield [failed(batch[0], error)]
        more = list(islice(items, size))
        if more:
            ended.add(submit(more))


async def _kind(address: str, timeout: float) -> str:
    """Return what it is that answers at an address."""
    comm = await connect(address, timeout=timeout,
                         **Security().get_connection_args('client'))
    try:
        await comm.write({'op': 'identity'})
        return (await comm.read())['type']
    finally:
        comm.abort()


def _silence() -> None:
    """Keep Dask's log lines off the console: what matters is reported here in one line."""
    names = [name for name in logging.root.manager.loggerDict
             if name.partition('.')[0] in ('distributed', 'tornado', 'asyncio')]
    for name in ('distributed', 'tornado', 'asyncio', *names):  # Dask gives some a level each
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _on_one_thread(function: Callable[..., list[Result]], *arguments: Any) -> list[Result]:
    """Do a task: there are as many of them as processors."""
    limit_threads(1)
    return function(*arguments)
