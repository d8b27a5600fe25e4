"""Arguments of the model: checked by name, brought to one shape, handed to a kernel."""

from collections.abc import Callable, Sequence
from math import prod
from typing import Any

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.kernels.compiled import Kernel


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


def state_function(kernel: Kernel, *names: str, outputs: int = 1) -> Callable[..., Any]:
    """
    Return the function of joint vectors that a kernel computes.

    ``names``: of the joint vectors.  Returned: takes them, each of shape (..., 6), the constants
    of an arm and an empty array for each output of one state; returns the output, or a tuple of
    several, for all states.  For one state that is the array that was given, so that all
    arguments go on to the kernel as they came: that takes no time.  Its errors name the vector.
    """
    inputs = len(names)
    output = inputs + 1 if outputs == 1 else slice(inputs + 1, None)

    def function(*arguments: Any) -> Any:
        try:
            # many states are not offered: Numba explains a refusal at length
            if arguments[0].ndim == 1 and kernel.single(*arguments) == 0:
                return arguments[output]
        except (AttributeError, TypeError):  # other types, or not compiled yet
            pass
        tails = [each.shape for each in arguments[inputs + 1:]]
        found = apply(kernel, names, arguments[:inputs], arguments[inputs], *tails)
        return found[0] if outputs == 1 else tuple(found)

    return function


def apply(kernel: Kernel, names: Sequence[str], given: Sequence[Any], constants: np.ndarray,
          *tails: tuple[int, ...]) -> list[np.ndarray]:
    """
    Run a kernel over all states, their leading dimensions broadcast; return its outputs.

    ``given``: the joint vectors, each of shape (..., 6); ``constants``: those of the arm;
    ``tails``: shape of an output for one state.
    """
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
        code = kernel.run(count, inputs, [constants],
                          [_flat(out, tail) for out, tail in zip(outputs, tails, strict=True)])
        if code:
            raise InputError(f'{", ".join(names)}: numbers so large that the result is not '
                             'finite; give smaller ones')
    return outputs


def _flat(array: np.ndarray, tail: tuple[int, ...]) -> np.ndarray:
    return array.reshape(-1) if len(tail) == 1 else array.reshape(-1, tail[-1])
