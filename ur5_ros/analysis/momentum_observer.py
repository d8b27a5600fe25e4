"""Generalised momentum observer: external joint torque without accelerations."""

import numpy as np

from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.parameters import ArmParameters

#: Rows that one pass takes, so that memory stays flat.
CHUNK = 16384


def external_torque(
    q: np.ndarray, qd: np.ndarray, effort: np.ndarray, period: float, arm: ArmParameters,
    gain: float, known: np.ndarray | None = None,
) -> np.ndarray:
    r"""
    Return the external joint torque that the generalised momentum p = M qd shows.

    .. math:: r = K \left(p - \int (\tau + C^T \dot q - g + r) dt - p(0)\right)

    so that :math:`\dot r = K (\tau_{ext} - r)` (De Luca and Mattone 2003; Haddadin, De Luca and
    Albu-Schaeffer 2017, eq. 24).  Sampled: each period's change of p against the mean of the model
    at its two ends.

    ``q``, ``qd`` (n, 6): states, manufacturer's angles [rad], [rad/s]; ``effort`` (n, 6): torque
    that acted up to each state [N m]; ``period``: time between two states [s]; ``gain``: K [1/s]:
    1 / K is the time after which a step shows to 63 %; ``known`` (n - 1,): which states are
    followed by the state one period later; the observer begins anew after the others.  Returned: r
    [N m]; zero in the first row, (n, 6).
    """
    momentum, drift = np.empty(q.shape), np.empty(q.shape)
    for start in range(0, len(q), CHUNK):
        rows = slice(start, start + CHUNK)
        M, C, g = dynamics_terms(q[rows] + arm.angle_offset, qd[rows], arm)
        momentum[rows] = np.einsum('nij,nj->ni', M, qd[rows])
        drift[rows] = np.einsum('nji,nj->ni', C, qd[rows]) - g
    gained = np.diff(momentum, axis=0)
    gained -= period * (effort[1:] + 0.5 * (drift[1:] + drift[:-1]))
    return first_order(gained / period, gain, period, known)


def first_order(values: np.ndarray, gain: float, period: float,
                known: np.ndarray | None = None) -> np.ndarray:
    """
    Return what r' = gain (value - r) makes of a value that acts up to each row.

    ``values`` (n - 1, m): mean from each row to the next; ``gain``: [1/s]; ``period``: time
    between two rows [s]; ``known`` (n - 1,): where not, r begins anew from zero.  Returned: r,
    exact for a value that is constant over each period, (n, m).
    """
    share = -np.expm1(-gain * period)
    r = np.zeros((len(values) + 1, values.shape[1]))
    good = np.isfinite(values).all(axis=1) & (True if known is None else known)
    for k, value in enumerate(values):
        if good[k]:
            r[k + 1] = r[k] + share * (value - r[k])
    return r
