"""Rows of the regression: regressor and torque, weighed by the same window."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.base_parameters import inertial_columns
from ur5_ros.analysis.identification.friction.families import friction_features
from ur5_ros.analysis.identification.samples import Samples, mean_temperature, samples_of
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters

#: Length of a window [s]; its Hann weights pass half the amplitude at 1/WINDOW Hz.
WINDOW = 0.15

#: Most windows that are taken of a run, and fewest periods in one.
MOST, SHORTEST = 2400, 4

#: Share of a window in which a joint may be too slow for a direction of its friction.
SLOW_SHARE = 0.01

#: Samples whose regressor is made at a time.
CHUNK = 4096


class Rows(NamedTuple):
    """Windows of runs; n of them."""

    inertial: np.ndarray
    """Regressor of the 66 parameters, shape (n, 6, 66)."""
    q: np.ndarray
    """Mean angles of the model [rad], shape (n, 6)."""
    speed: np.ndarray
    """Mean speed at which friction acts [rad/s], shape (n, 6)."""
    direction: np.ndarray
    """Mean direction of dry friction, -1 to 1, shape (n, 6)."""
    friction: np.ndarray
    """Features of friction, shape (n, 6, 12)."""
    effort: np.ndarray
    """Torque [N m], shape (n, 6)."""
    current: np.ndarray
    """Motor current [A], shape (n, 6); NaN where none is recorded."""
    sliding: np.ndarray
    """Whether the joint moves enough for its friction to be determined, shape (n, 6)."""
    time: np.ndarray
    """Middle of the window [s], shape (n,)."""
    run: np.ndarray
    """Which run it is of, shape (n,)."""
    exact: bool
    """Whether the states come without noise from a plant of this time step."""


    def take(self, which: np.ndarray) -> 'Rows':
        """Return some of the windows."""
        return self._replace(**{name: getattr(self, name)[which] for name in _ARRAYS})


_ARRAYS = tuple(name for name in Rows._fields if name != 'exact')


def rows_of(runs: Sequence[Run], arm: ArmParameters) -> Rows:
    """
    Return the windows of runs.

    The regressor is linear in the parameters, so a window of it times the parameters is the same
    window of the torque, without bias (parallel filtering, Gautier 1997): a Hann window takes away
    noise of the accelerations above 1/:data:`WINDOW` Hz.
    """
    parts: list[Rows] = []
    temperature = mean_temperature(runs)
    for number, run in enumerate(runs):
        found = [_rows(part, run, number, arm) for part in samples_of(run, arm, temperature)]
        long_enough = [rows for rows in found if rows is not None]
        if not long_enough:
            raise InputError(f'{run.name}: too few states with a torque follow each other; '
                             f'{WINDOW:g} s without a gap are needed')
        parts += long_enough
    exact = all(part.exact for part in parts)
    return parts[0]._replace(exact=exact, **{
        name: np.concatenate([getattr(part, name) for part in parts]) for name in _ARRAYS})


def _rows(part: Samples, run: Run, number: int, arm: ArmParameters) -> Rows | None:
    length = max(SHORTEST, round(WINDOW * run.control_rate))
    if len(part.q) < length:
        return None
    step = max(length // 2, len(run.stamp) // MOST, 1)
    window = hann(length)
    inertial = np.concatenate([
        windows(inertial_columns(part.q[rows], part.qd[rows], part.qdd[rows], arm), window, step)
        for rows in _chunks(len(part.q), length, step)])
    mean = {name: windows(getattr(part, name), window, step)
            for name in ('q', 'speed', 'direction', 'effort')}
    friction = windows(friction_features(
        part.speed, part.direction, gravity_torque(part.q, arm), part.warmer), window, step)
    share = windows(part.slow.astype(float), window, step)
    current = (np.full_like(mean['q'], np.nan) if part.current is None
               else windows(part.current, window, step))
    time = windows(part.time[:, None], window, step)[:, 0]
    return Rows(
        inertial=inertial, friction=friction, current=current,
        sliding=share <= (0.0 if part.exact else SLOW_SHARE),
        time=time, run=np.full(len(time), number), exact=part.exact, **mean)


def last_fifth(rows: Rows) -> tuple[Rows, Rows]:
    """Return the rows without the last fifth of the first run, and that fifth."""
    first = np.flatnonzero(rows.run == 0)
    out = np.zeros(len(rows.run), dtype=bool)
    out[first[len(first) * 4 // 5:]] = True
    return rows.take(~out), rows.take(out)


def of_three(rows: Rows, values: np.ndarray) -> np.ndarray:
    """
    Return a quarter, a half and a quarter of neighbouring windows: a window of twice the length.

    NaN at gaps, shape as given less two rows.

    """
    step = np.diff(rows.time)
    beside = (np.abs(np.diff(step)) < 0.5 * np.median(step)) & (rows.run[2:] == rows.run[:-2])
    mean = 0.25 * values[:-2] + 0.5 * values[1:-1] + 0.25 * values[2:]
    return np.where(beside[:, None], mean, np.nan)


def hann(length: int) -> np.ndarray:
    """Return Hann weights that add up to one."""
    weights = np.sin(np.pi * (np.arange(length) + 0.5) / length)**2
    return weights / weights.sum()


def windows(values: np.ndarray, window: np.ndarray, step: int) -> np.ndarray:
    """Return weighted sums of consecutive rows, a window every ``step`` rows."""
    flat = values.reshape(len(values), -1)
    view = np.lib.stride_tricks.sliding_window_view(flat, len(window), axis=0)[::step]
    return (view @ window).reshape(-1, *values.shape[1:])


def _chunks(n: int, length: int, step: int) -> list[slice]:
    """Return slices whose windows, one after the other, are those of the whole."""
    count = (n - length) // step + 1
    each = max(1, CHUNK // step)
    return [slice(first * step, (min(first + each, count) - 1) * step + length)
            for first in range(0, count, each)]
