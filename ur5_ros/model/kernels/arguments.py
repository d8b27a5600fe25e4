"""Arguments of the model: checked by name, brought to one shape, handed to a kernel."""

from collections.abc import Callable, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy import empty

from ur5_ros.errors import InputError
from ur5_ros.model.kernels.compiled import Kernel
from ur5_ros.model.parameters import ArmParameters


def finite_array(name: str, value: Any, tail: tuple[int, ...]) -> np.ndarray:
    """Return ``value`` as a C-contiguous float64 array of shape (..., *tail)."""
    shape = '(' + ', '.join(['...', *map(str, tail)]) + ')'
    try:
        array = np.asarray(value)
        if array.dtype.kind not in 'fiu':
            raise TypeError
        array = np.asarray(array, dtype=np.float64, order='C')
    except (TypeError, ValueError):
        raise InputError(f'{name} is no array of real numbers; give shape {shape}') from None
    if np.ndim(value) < len(tail) or array.shape[array.ndim - len(tail):] != tail:
        raise InputError(f'{name} has shape {np.shape(value)}; give {shape}')
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f'{name}{list(where)} is {array[where]}; give finite numbers')
    return array


def state_function(kernel: Kernel, names: Sequence[str], *tails: tuple[int, ...],
                   ) -> Callable[..., Any]:
    """
    Return the function of an arm and joint vectors that a kernel computes.

    ``names``: the arguments, each of shape (..., 6).  Returned: takes an arm and the arguments;
    returns an array of shape (..., *tail), a list of them where there are several outputs.  Its
    errors name the argument.
    """
    tail = tails[0]

    def one(arm: ArmParameters, *given: Any) -> np.ndarray:
        output = empty(tail)
        try:
            if kernel.single(*given, arm.constants, output) == 0:
                return output
        except TypeError:  # many states, other types, or not compiled yet
            pass
        return _apply(kernel, names, given, arm, tails)[0]

    def several(arm: ArmParameters, *given: Any) -> list[np.ndarray]:
        outputs = [empty(tail) for tail in tails]
        try:
            if kernel.single(*given, arm.constants, *outputs) == 0:
                return outputs
        except TypeError:
            pass
        return _apply(kernel, names, given, arm, tails)

    return one if len(tails) == 1 else several


def _apply(kernel: Kernel, names: Sequence[str], given: Sequence[Any], arm: ArmParameters,
           tails: Sequence[tuple[int, ...]]) -> list[np.ndarray]:
    """Broadcast the leading dimensions and run the kernel over all states."""
    arrays = [finite_array(name, value, (6,)) for name, value in zip(names, given, strict=True)]
    try:
        lead = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
    except ValueError:
        shapes = ', '.join(f'{name} {array.shape}'
                           for name, array in zip(names, arrays, strict=True))
        raise InputError(f'leading dimensions do not match: {shapes}') from None
    inputs = [np.ascontiguousarray(np.broadcast_to(array, (*lead, 6))).reshape(-1)
              for array in arrays]
    outputs = [np.empty(lead + tail) for tail in tails]
    count = prod(lead)
    if count:
        code = kernel.run(count, inputs, [arm.constants],
                          [_flat(out, tail) for out, tail in zip(outputs, tails, strict=True)])
        if code:
            raise InputError(f'{", ".join(names)}: numbers so large that the result is not '
                             'finite; give smaller ones')
    return outputs


def _flat(array: np.ndarray, tail: tuple[int, ...]) -> np.ndarray:
    return array.reshape(-1) if len(tail) == 1 else array.reshape(-1, tail[-1])
