"""Compiled kernels: compiled at first use, kept on disk where possible, threaded when large."""

import gc
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from typing import Any

import numpy as np
from numba import int64, njit, types
from numba.core.caching import FunctionCache

try:
    from numba.core.runtime import rtsys
except ImportError:  # not public: it may go
    rtsys = None  # type: ignore[assignment]

from ur5_ros.model.kernels.compile_notice import announce
from ur5_ros.model.kernels.kernel_cache import compiled_sources

#: Argument types of kernels: inputs may be read-only (R) and outputs are written (W).
R1 = types.Array(types.float64, 1, 'C', readonly=True)
R2 = types.Array(types.float64, 2, 'C', readonly=True)
W1 = types.Array(types.float64, 1, 'C')
W2 = types.Array(types.float64, 2, 'C')
B1 = types.Array(types.boolean, 1, 'C')

#: From this many states on the lock is released and the work is shared among threads; later for a
#: hot kernel, which is compiled a second time for it: half a minute at 1 kHz does without.
PARALLEL_STATES, HOT_PARALLEL_STATES = 1024, 32_768

#: How all is compiled: fused multiply-add is allowed, nothing is called from C, and nothing is
#: allocated, so that no references to arrays are counted: up to half of the time of a call.
_OPTIONS: dict[str, Any] = {
    'fastmath': {'contract'}, 'error_model': 'numpy', 'no_cfunc_wrapper': True, '_nrt': False,
}
_HELPER_OPTIONS: dict[str, Any] = {
    **_OPTIONS, 'forceinline': True, 'no_cpython_wrapper': True,
}


def inlined(function: Callable[..., Any]) -> Any:
    """
    Declare a helper function of kernels; only compiled code may call it.

    A quarter of the time to compile is saved without a wrapper for Python, and some more as a
    whole number is an argument like any other: Numba would compile once for each of 1, 2, 3.
    """
    helper = njit(**_HELPER_OPTIONS)(function)
    template = helper.get_call_template
    helper.get_call_template = lambda args, kws: template(tuple(map(types.unliteral, args)), kws)
    return helper


_COMPILING = threading.RLock()
_most_threads = 0


class Kernel:
    """
    A function over flat arrays of states, compiled at its first use.

    ``single`` is the compiled function; it raises ``TypeError`` for arguments of other types, as
    well as before it is compiled: callers then go through :meth:`run`, which compiles.  That of a
    hot kernel keeps the interpreter lock: handing it over would take a twentieth of such a call;
    the others are compiled once for one state and for many.

    """

    def __init__(self, function: Callable[..., int], argument_types: Sequence[types.Type],
                 hot: bool):
        self._function = function
        self._signature = int64(*argument_types)
        self._hot = hot
        self._parallel_states = HOT_PARALLEL_STATES if hot else PARALLEL_STATES
        self._many: Callable[..., int] | None = None
        self._ready = False
        self.single: Callable[..., int] = _not_compiled

    def prepare(self) -> None:
        """Compile, or load from the cache, what a single call needs."""
        with _COMPILING:
            if not self._ready:
                self.single = _compile(self._function, self._signature, nogil=not self._hot)
                self._ready = True

    def run(self, count: int, inputs: Sequence[np.ndarray], shared: Sequence[Any],
            outputs: Sequence[np.ndarray]) -> int:
        """
        Apply the kernel to ``count`` states, on all processors if they are many.

        ``inputs``, ``outputs``: C-contiguous arrays whose first axis is a multiple of ``count``
        long.  Returned: the largest code that the kernel returned; 0 where all went well.
        """
        if count < self._parallel_states:
            self.prepare()
            return self.single(*inputs, *shared, *outputs)
        many, workers = self._prepare_many(), _processors()
        edges = [count * i // workers for i in range(workers + 1)]
        codes = [0] * workers

        def work(i: int) -> None:
            def part(x):
                return x[len(x) // count * edges[i]:len(x) // count * edges[i + 1]]
            codes[i] = many(*map(part, inputs), *shared, *map(part, outputs))

        threads = [threading.Thread(target=work, args=(i,)) for i in range(1, workers)]
        for thread in threads:
            thread.start()
        work(0)
        for thread in threads:
            thread.join()
        return max(codes)

    def _prepare_many(self) -> Callable[..., int]:
        """Compile, or load from the cache, and return what a call for many states needs."""
        with _COMPILING:
            if self._many is None and not self._hot:
                self.prepare()
                self._many = self.single
            if self._many is None:
                self._many = _compile(self._function, self._signature, nogil=True)
            return self._many


def kernel(
    *argument_types: types.Type, hot: bool = False,
) -> Callable[[Callable[..., int]], Kernel]:
    """Declare a function as a :class:`Kernel` with these argument types, returning an int."""
    return lambda function: Kernel(function, argument_types, hot)


class _SourceCache(FunctionCache):
    """
    Numba's cache on disk, also keyed by the text of all files of the model that are compiled.

    Numba looks at the file of the kernel alone, not at the files of the functions it calls.  And
    before it looks for a kept function it declares all of NumPy to its compiler (and loads SciPy
    where there is one), which takes a quarter of a second and is of use only for compiling.
    """

    def __init__(self, function: Callable[..., int], options: str):
        super().__init__(function)
        self._options = options

    def load_overload(self, signature, context):
        if rtsys is None:
            return super().load_overload(signature, context)
        rtsys.initialize(context)  # all of the declarations that compiled code refers to
        found = self._load_overload(signature, context)
        if found is None:  # Numba declares and compiles
            announce(self._py_func.__name__)
        return found

    def _index_key(self, signature, codegen):
        return (super()._index_key(signature, codegen), self._options, source_digest())


@contextmanager
def _garbage_kept() -> Iterator[None]:
    """Put the garbage collector off: the compiler makes many objects that stay."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


@_garbage_kept()
def _compile(function: Callable[..., int], signature: Any, nogil: bool) -> Callable[..., int]:
    def new() -> Any:
        return njit(**_OPTIONS, nogil=nogil)(function)

    dispatcher = new()
    try:
        dispatcher._cache = _SourceCache(function, f'nogil={nogil}')
        dispatcher.compile(signature)
    except Exception:  # no folder can be written, the disk is full, a kept file is damaged
        dispatcher = new()
        dispatcher.compile(signature)
    dispatcher.disable_compile()
    return dispatcher


@cache
def source_digest() -> str:
    """Return a digest of all files whose functions are compiled."""
    return sha256(b''.join(text for _, text in compiled_sources())).hexdigest()


def limit_threads(number: int) -> None:
    """
    Let many states be shared among at most so many threads of this process.

    For a process that is one of several at work, as many as there are processors; the results
    do not depend on it.

    ``number``: threads; 0 = as many as there are processors, the default.
    """
    global _most_threads
    _most_threads = number


def _processors() -> int:
    if _most_threads:
        return _most_threads
    if hasattr(os, 'sched_getaffinity'):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _not_compiled(*_: Any) -> int:
    raise TypeError('not compiled yet')
