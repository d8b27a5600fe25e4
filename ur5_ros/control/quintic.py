"""Polynomials of fifth degree between two references."""

import numpy as np

from ur5_ros.signals import Reference


def quintic(start: Reference, end: Reference, length: float) -> np.ndarray:
    """
    Return the quintic that meets position, velocity and acceleration at both ends.

    ``start``, ``end``: what to meet, arrays of shape (6,); ``length``: time between them [s],
    greater than zero.  Returned: coefficients: a row a power of time, a column a joint, (6, 6).
    """
    step = end.q - start.q - start.qd * length - start.qdd * length**2 / 2.0
    slope = (end.qd - start.qd - start.qdd * length) * length
    bend = (end.qdd - start.qdd) * length**2
    return np.array([
        start.q, start.qd, start.qdd / 2.0,
        (10.0 * step - 4.0 * slope + 0.5 * bend) / length**3,
        (-15.0 * step + 7.0 * slope - bend) / length**4,
        (6.0 * step - 3.0 * slope + 0.5 * bend) / length**5,
    ])


def powers(t: float) -> np.ndarray:
    """
    Return the rows that turn coefficients into position, velocity and acceleration.

    ``t``: time since the start of the polynomial [s].  Returned: powers of t and their first two
    derivatives, (3, 6).
    """
    t2, t3 = t * t, t * t * t
    return np.array([
        (1.0, t, t2, t3, t2 * t2, t2 * t3),
        (0.0, 1.0, 2.0 * t, 3.0 * t2, 4.0 * t3, 5.0 * t2 * t2),
        (0.0, 0.0, 2.0, 6.0 * t, 12.0 * t2, 20.0 * t3),
    ])
