"""What an exercise is: lines with points, each a check of what the solution's file computes."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.control.laws.user_law import real_numbers

#: A number of the solution may differ from the oracle's by this, absolutely and relatively.
TOLERANCE = 1e-6


class Mark(NamedTuple):
    """What a line of the grading earned."""

    line: str
    points: float
    of: float
    reason: str
    """In one line why points were lost; empty if none were."""
    mistake: str = ''
    """Name of a usual mistake that explains it."""


class Line(NamedTuple):
    """A line of the grading."""

    name: str
    points: float
    check: Callable[[Any, np.random.Generator], tuple[str, str]]
    """Given the module and random numbers, returns reason and mistake; two empty texts pass."""


class Exercise(NamedTuple):
    """Lines of which the points add up to ten."""

    name: str
    lines: tuple[Line, ...]


class WrongAnswer(Exception):
    """The solution did not answer as the exercise asks; the text is the reason."""


def answer(module: Any, name: str, *arguments: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return what a function of the solution gives, as finite numbers of a shape."""
    function = getattr(module, name, None)
    if not callable(function):
        raise WrongAnswer(f'there is no function {name}')
    given = function(*(np.array(each) if isinstance(each, np.ndarray) else each
                       for each in arguments))
    return checked(name, given, shape)


def checked(name: str, given: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return what a function of the solution gave; WrongAnswer unless finite, of the shape."""
    try:
        array = real_numbers(given)
    except ValueError as error:
        raise WrongAnswer(f'{name} returns {error}; it should return numbers') from None
    if array.shape != shape:
        raise WrongAnswer(f'{name} returns the shape {array.shape}; it should be {shape}')
    if not np.isfinite(array).all():
        raise WrongAnswer(f'{name} returns numbers that are not finite')
    return array


def compare(what: str, got: np.ndarray, right: np.ndarray,
            mistakes: Mapping[str, np.ndarray], tolerance: float = TOLERANCE) -> tuple[str, str]:
    """Return why answers are wrong and the frequent mistake that gives the same numbers."""
    if _near(got, right, tolerance):
        return '', ''
    far = float(np.abs(got - right).max())
    named = next((name for name, numbers in mistakes.items()
                  if _near(got, numbers, tolerance)), '')
    return f'{what} differs by up to {far:.3g}', named


def _near(a: np.ndarray, b: np.ndarray, tolerance: float) -> bool:
    return bool(np.allclose(a, b, rtol=tolerance, atol=tolerance))
