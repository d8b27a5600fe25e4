"""Arguments of the model: checked by name, brought to one shape, handed to a kernel."""

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.kernels.compiled import Kernel

#: A named argument and the shape of one item: ('q', q, (6,)).
Argument = tuple[str, Any, tuple[int, ...]]


def finite_array(name: str, value: Any, tail: tuple[int, ...]) -> np.ndarray:
    """
    Return ``value`` as a C-contiguous float64 array of shape (..., *tail).

    Raises
    ------
    InputError
        If it holds no real numbers, has another shape, or a number is not finite.

    """
    wanted = '(' + ', '.join(['...', *map(str, tail)]) + ')'
    try:
        array = np.asarray(value)
        if array.dtype.kind not in 'fiu':
            raise TypeError
        array = np.asarray(array, dtype=np.float64, order='C')
    except (TypeError, ValueError):
        raise InputError(f'{name} is no array of real numbers; give shape {wanted}') from None
    if np.ndim(value) < len(tail) or array.shape[array.ndim - len(tail):] != tail:
        raise InputError(f'{name} has shape {np.shape(value)}; give {wanted}')
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f'{name}{list(where)} is {array[where]}; give finite numbers')
    return array


def apply(kernel: Kernel, arguments: Sequence[Argument], shared: Sequence[Any],
          tails: Sequence[tuple[int, ...]]) -> list[np.ndarray]:
    """
    Broadcast the leading dimensions, run the kernel over all states, return its outputs.

    Parameters
    ----------
    kernel : Kernel
        Takes every argument with all but its last axis flattened, then ``shared``, then outputs.
    arguments : sequence of (name, value, shape of one item)
        What the caller was given.
    shared : sequence
        Passed on as they are.
    tails : sequence of tuple of int
        Shape of one item of each output.

    Returns
    -------
    list of numpy.ndarray
        Outputs of shape (..., *tail).

    Raises
    ------
    InputError
        If an argument is refused by :func:`finite_array`, or leading shapes do not match.

    """
    arrays = [finite_array(name, value, tail) for name, value, tail in arguments]
    leads = [array.shape[:array.ndim - len(tail)]
             for array, (_, _, tail) in zip(arrays, arguments, strict=True)]
    try:
        lead = np.broadcast_shapes(*leads)
    except ValueError:
        shapes = ', '.join(f'{name} {array.shape}'
                           for array, (name, _, _) in zip(arrays, arguments, strict=True))
        raise InputError(f'leading dimensions do not match: {shapes}') from None
    inputs = []
    for array, own, (_, _, tail) in zip(arrays, leads, arguments, strict=True):
        if own != lead:
            array = np.ascontiguousarray(np.broadcast_to(array, lead + tail))
        inputs.append(_flat(array, tail))
    outputs = [np.empty(lead + tail) for tail in tails]
    count = prod(lead)
    if count:
        code = kernel.run(count, inputs, shared,
                          [_flat(out, tail) for out, tail in zip(outputs, tails, strict=True)])
        if code:
            names = ', '.join(name for name, _, _ in arguments)
            raise InputError(f'{names}: numbers so large that the result is not finite; '
                             'give smaller ones')
    return outputs


def _flat(array: np.ndarray, tail: tuple[int, ...]) -> np.ndarray:
    return array.reshape(-1) if len(tail) == 1 else array.reshape(-1, tail[-1])
