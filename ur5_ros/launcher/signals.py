"""Signals of a command and of the processes that it starts."""

import ctypes
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_LIBC = ctypes.CDLL(None)  # loaded here: a child of many threads loads nothing before its program


@contextmanager
def interrupted_by_sigterm() -> Iterator[None]:
    """Let SIGTERM end the block as Ctrl-C does, so that it leaves nothing behind."""
    if threading.current_thread() is not threading.main_thread():  # a worker's tasks are not
        yield
        return
    handler = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, handler)


@contextmanager
def held_back() -> Iterator[None]:
    """
    Let Ctrl-C and SIGTERM act at the end of the block: what it begins can then be ended.

    Threads and processes that are begun in it never take Ctrl-C themselves.

    """
    came: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    if main:
        handler = signal.signal(signal.SIGTERM, lambda number, frame: came.append(number))
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if main:
            signal.signal(signal.SIGTERM, handler)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        if came:
            signal.raise_signal(signal.SIGTERM)


def end_with_parent(number: int = signal.SIGTERM, parent: int | None = None) -> None:
    """
    Let the process that calls it end with its parent, by a signal.

    ``parent``: its id, where it may have ended before this call.
    """
    _LIBC.prctl(_PR_SET_PDEATHSIG, number)
    if parent is not None and os.getppid() != parent:
        os.kill(os.getpid(), number)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
