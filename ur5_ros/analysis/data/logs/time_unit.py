"""The unit of a log's time, where its name does not state one: by what the motion allows."""

from collections.abc import Mapping

import numpy as np

#: Units that are tried -> what they are called.
SCALES = {1.0: 's', 1e-3: 'ms', 1e-6: 'us', 1e-9: 'ns'}

#: A time since 1970 beyond this is no number of seconds [s]: the year 5138.
LATEST_TIME = 1e11

#: Slowest and fastest rate that a log has where no velocity decides [Hz].
SLOWEST, FASTEST = 0.9, 1e4

#: Steps of the time so many times the usual one are gaps.
GAP_FACTOR = 10.0

#: Factor between positions and integrated velocities from which on the unit is another one.
UNIT_FACTOR = 10.0


def seconds_of(t: np.ndarray, values: Mapping[str, np.ndarray], stated: bool,
               remarks: list[str]) -> np.ndarray:
    """
    Return a log's time in seconds.

    ``t`` (n,): as the log has it, increasing; ``values``: quantity -> columns; ``q`` and ``qd``
    are used; ``stated``: whether the unit is known and ``t`` is in seconds.
    """
    if stated:
        return t
    scale = _by_velocity(t, values)
    if scale is None:
        scale = _by_size(t)
    if scale != 1.0:
        remarks.append(f'the time is in {SCALES[scale]}, as the motion shows')
        # a time since 1970 in nanoseconds keeps its differences only before it is scaled
        return (t - t[0]) * scale + t[0] * scale
    return t


def _by_velocity(t: np.ndarray, values: Mapping[str, np.ndarray]) -> float | None:
    """Return the unit by which positions are integrated velocities; None without a motion."""
    if 'qd' not in values:
        return None
    step, qd = np.diff(t), values['qd']
    near = step <= GAP_FACTOR * np.median(step)  # the velocity within a gap is not known
    way = np.abs(np.diff(values['q'], axis=0)[near]).sum()
    integral = (0.5 * np.abs(qd[1:] + qd[:-1]) * step[:, None])[near].sum()
    if way < 1e-3 or not integral > 0.0:
        return None
    ratio = way / integral
    scale = min(SCALES, key=lambda each: abs(np.log(ratio / each)))
    return scale if 1.0 / UNIT_FACTOR < ratio / scale < UNIT_FACTOR else 1.0


def _by_size(t: np.ndarray) -> float:
    """Return the unit by which a time since 1970, or a rate, is one that logs have."""
    if t[-1] > LATEST_TIME:
        return next(scale for scale in SCALES if t[-1] * scale <= LATEST_TIME)
    rate = 1.0 / float(np.median(np.diff(t)))
    return next((scale for scale in SCALES if SLOWEST < rate / scale < FASTEST), 1.0)
