"""Motions: what the reference is at an integer time since their start."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ur5_ros.signals import Reference

SECOND = 1_000_000_000


class Motion(Protocol):
    """A reference along time; asking changes nothing."""

    duration: int
    """Length [ns]."""

    def at(self, time: int) -> Reference:
        """Return the reference ``time`` nanoseconds after the start, 0 <= time <= duration."""


def seconds(time: int, rate: int) -> tuple[float, int | None]:
    """
    Return a time in seconds, and its index on the grid of control periods where it lies on it.

    Stamps are rounded to nanoseconds; a time within one nanosecond of i / rate means i / rate.

    Parameters
    ----------
    time : int
        Nanoseconds.
    rate : int
        Grid points a second.

    Returns
    -------
    float
        Seconds.
    int or None
        The index i, or None off the grid.

    """
    index, rest = divmod(time * rate + SECOND // 2, SECOND)
    if abs(rest - SECOND // 2) <= rate:
        return index / rate, index
    return time / SECOND, None


class Still:
    """The arm stands at one configuration."""

    def __init__(self, q: np.ndarray):
        self.duration = 0
        zero = np.zeros(6)
        self._reference = Reference(_fixed(q), _fixed(zero), _fixed(zero))

    def at(self, time: int) -> Reference:
        """Return the configuration."""
        return self._reference


class Sampled:
    """
    A motion computed beforehand on the grid of control periods, exactly by ``between`` elsewhere.

    Grid and ``between`` come from the same formulas, so that a time gives the same bits either
    way.

    """

    def __init__(
        self,
        duration: float,
        rate: int,
        table: Reference,
        between: Callable[[float, np.ndarray], Reference],
    ):
        self.duration = round(duration * SECOND)
        self._rate = rate
        self._q, self._qd, self._qdd = (_fixed(array) for array in table)
        self._between = between

    @property
    def table(self) -> Reference:
        """The rows of all control periods, shapes (n, 6)."""
        return Reference(self._q, self._qd, self._qdd)

    def at(self, time: int) -> Reference:
        """Return the row of the table, or the formula's value off the grid."""
        t, index = seconds(time, self._rate)
        if index is not None and index < len(self._q):
            return Reference(self._q[index], self._qd[index], self._qdd[index])
        neighbour = min(int(t * self._rate), len(self._q) - 1)
        q, qd, qdd = self._between(t, self._q[neighbour])
        return Reference(q[0], qd[0], qdd[0])


class InSequence:
    """One motion after the other; the first is drawn out to whole control periods."""

    def __init__(self, first: Motion, second: Motion, rate: int):
        self._first, self._second = first, second
        periods = -(-first.duration * rate // SECOND)
        self._switch = (2 * periods * SECOND + rate) // (2 * rate)
        self.duration = self._switch + second.duration

    def at(self, time: int) -> Reference:
        """Return the reference of the motion whose turn it is."""
        if time < self._switch:
            return self._first.at(min(time, self._first.duration))
        return self._second.at(time - self._switch)


def grid(duration: float, rate: int) -> np.ndarray:
    """
    Return the times of the control periods within a motion, both ends included.

    Parameters
    ----------
    duration : float
        Seconds.
    rate : int
        Control periods a second.

    Returns
    -------
    numpy.ndarray, shape (n,)
        i / rate [s].

    """
    return np.arange(int(duration * rate + 1e-6) + 1) / rate


def _fixed(array: np.ndarray) -> np.ndarray:
    """Return a read-only copy: references are handed out as views."""
    copy = np.array(array, dtype=float)
    copy.flags.writeable = False
    return copy
