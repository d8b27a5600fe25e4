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


#: The short way of a state function.  Its arguments are spelled out: `*given` would take a sixth
#: of the call for one state.
_STATE_FUNCTION = """
def function(arm, {given}):
    {outputs} = {arrays}
    try:
        if kernel.single({given}, arm.constants, {outputs}) == 0:
            return {outputs}
    except TypeError:  # many states, other types, or not compiled yet
        pass
    [{outputs}] = apply(kernel, names, [{given}], arm, *tails)
    return {outputs}
"""


def state_function(kernel: Kernel, names: Sequence[str], *tails: tuple[int, ...],
                   ) -> Callable[..., Any]:
    """
    Return the function of an arm and joint vectors that a kernel computes.

    ``names``: the arguments, each of shape (..., 6).  Returned: takes an arm and the arguments;
    returns an array of shape (..., *tail), or a tuple of them.  Its errors name the argument.
    """
    text = _STATE_FUNCTION.format(
        given=', '.join(names), outputs=', '.join(f'output_{i}' for i in range(len(tails))),
        arrays=', '.join(f'empty({tail if len(tail) > 1 else tail[0]})' for tail in tails))
    scope: dict[str, Any] = {
        'kernel': kernel, 'names': names, 'tails': tails, 'empty': empty, 'apply': apply}
    exec(compile(text, f'<function of {", ".join(names)}>', 'exec'), scope)
    return scope['function']


def apply(kernel: Kernel, names: Sequence[str], given: Sequence[Any], arm: ArmParameters,
          *tails: tuple[int, ...]) -> list[np.ndarray]:
    """
    Run a kernel over all states, their leading dimensions broadcast; return its outputs.

    ``given``: the arguments, each of shape (..., 6); ``tails``: shape of an output for one state.
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
        code = kernel.run(count, inputs, [arm.constants],
                          [_flat(out, tail) for out, tail in zip(outputs, tails, strict=True)])
        if code:
            raise InputError(f'{", ".join(names)}: numbers so large that the result is not '
                             'finite; give smaller ones')
    return outputs


def _flat(array: np.ndarray, tail: tuple[int, ...]) -> np.ndarray:
    return array.reshape(-1) if len(tail) == 1 else array.reshape(-1, tail[-1])
