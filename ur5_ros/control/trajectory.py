"""Motions: what the reference is at an integer time since their start."""

from typing import Protocol

import numpy as np

from ur5_ros.control.quintic import powers, quintic
from ur5_ros.signals import Reference

SECOND = 1_000_000_000


class Trajectory(Protocol):
    """A reference along time; evaluating it changes nothing."""

    duration: int
    """Length [ns]."""

    def at(self, time: int) -> Reference:
        """Return the reference ``time`` nanoseconds after the start, 0 <= time <= duration."""


def seconds(time: int, rate: int) -> tuple[float, int | None]:
    """
    Return a time in seconds, and its index on the grid of control periods where it lies on it.

    Stamps are rounded to nanoseconds; a time within one nanosecond of i / rate means i / rate.

    Returned: the index i, or None off the grid.
    """
    index, rest = divmod(time * rate + SECOND // 2, SECOND)
    if abs(rest - SECOND // 2) <= rate:
        return index / rate, index
    return time / SECOND, None


class Hold:
    """One configuration, without end."""

    def __init__(self, q: np.ndarray):
        self.duration = 0
        zero = np.zeros(6)
        self._reference = Reference(_fixed(q), _fixed(zero), _fixed(zero))

    def at(self, time: int) -> Reference:
        """Return the configuration."""
        return self._reference


class Step:
    """A configuration, one jump on purpose, and the configuration after it."""

    def __init__(self, before: np.ndarray, after: np.ndarray, jump: int, duration: int):
        self.duration = duration
        self._before, self._after, self._jump = Hold(before), Hold(after), jump

    def at(self, time: int) -> Reference:
        """Return the configuration before or, from the jump on, after it."""
        return (self._before if time < self._jump else self._after).at(0)


class Sampled:
    """
    A motion computed beforehand for every control period, smooth between the rows.

    Between two rows the quintic that meets both in position, velocity and acceleration stands for
    the motion: at a thousand rows a second the difference is below rounding.

    """

    def __init__(self, times: np.ndarray, rate: int, table: Reference):
        self.duration = round(float(times[-1]) * SECOND)
        self._times = times.tolist()
        self._rate = rate
        self._q, self._qd, self._qdd = (_fixed(array) for array in table)

    def at(self, time: int) -> Reference:
        """Return the row of the table, or what lies between two rows."""
        t, index = seconds(time, self._rate)
        if index is not None and index < len(self._times) and self._times[index] == t:
            return self._row(index)
        if time >= self.duration:
            return self._row(-1)
        index = min(int(t * self._rate), len(self._times) - 2)
        length = self._times[index + 1] - self._times[index]
        curve = quintic(self._row(index), self._row(index + 1), length)
        return Reference(*(powers(t - self._times[index]) @ curve))

    def _row(self, index: int) -> Reference:
        return Reference(self._q[index], self._qd[index], self._qdd[index])


class TrajectorySequence:
    """One motion after the other; the first is drawn out to whole control periods."""

    def __init__(self, first: Trajectory, second: Trajectory, rate: int):
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
    Return the times of the control periods within a motion, and its end.

    Returned: i / rate [s] and at last ``duration``, (n,).
    """
    times = np.arange(int(duration * rate + 1e-6) + 1) / rate
    if duration - times[-1] < 1e-9:
        return times
    return np.append(times, duration)


def _fixed(array: np.ndarray) -> np.ndarray:
    """Return a read-only copy: references are handed out as views."""
    copy = np.array(array, dtype=float)
    copy.flags.writeable = False
    return copy
