"""Dry friction, brakes and stops at the new velocity: one convex problem, solved exactly."""

import numpy as np

#: Faces of the problem that are tried at most; six joints need fewer than twenty.
_MOST_FACES = 1000
#: What rounding may do to a sum of torques, by the largest of them.
_ROUNDING = 1e-13


def resisted_change(
    A: np.ndarray, drive: np.ndarray, qd: np.ndarray, level: np.ndarray,
    lower: np.ndarray, upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    r"""
    Return the change of velocity under a drive, against resistance taken at the new velocity.

    Find v' = qd + delta and the resistance f with

    .. math:: A \delta + f = drive, \quad f_i \in level_i \, \mathrm{Sgn}(v'_i) + N(v'_i)

    where Sgn(0) = [-1, 1] and N is the reaction of a stop: zero between ``lower`` and ``upper``,
    of any size outwards at them.  It is the optimality condition of a strictly convex problem
    (minimise v'^T A v' / 2 - (drive + A qd)^T v' + level^T |v'| between the stops), so that there
    is exactly one solution.  Resistance therefore stops a motion but never reverses it, whatever
    the step.  With ``level`` = the torque limits, -f is the brake that minimises v'^T A v'.

    Parameters
    ----------
    A : numpy.ndarray, shape (6, 6)
        Inertia by time, and what else is linear in the new velocity [N m s/rad]; positive
        definite.
    drive : numpy.ndarray, shape (6,)
        Torque that would act at constant velocity [N m].
    qd : numpy.ndarray, shape (6,)
        Velocity before [rad/s].
    level : numpy.ndarray, shape (6,)
        Largest resistance [N m]; zero = none.
    lower, upper : numpy.ndarray, shape (6,)
        Velocities at which the stops are reached [rad/s]; infinite = none.

    Returns
    -------
    delta : numpy.ndarray, shape (6,)
        Change of velocity [rad/s].
    f : numpy.ndarray, shape (6,)
        Resistance [N m].

    """
    if not level.any():
        delta = np.linalg.solve(A, drive)
        if (lower <= qd + delta).all() and (qd + delta <= upper).all():
            return delta, np.zeros(6)
    else:
        f = drive + A @ qd  # what it takes to stop every joint at once
        if (np.abs(f) <= level).all() and (lower <= 0.0).all() and (upper >= 0.0).all():
            return -qd, f
    v = np.where(np.abs(np.diag(A) * qd) < level, 0.0, qd)  # slow joints: held, as a first guess
    v = np.minimum(np.maximum(v, lower), upper)
    sign = np.sign(v)
    pinned = (v <= lower) | (v >= upper) | ((v == 0.0) & (level > 0.0))
    size = np.abs(drive).max() + level.max()
    for _ in range(_MOST_FACES):
        delta = _best_on_face(A, drive - sign * level, v - qd, pinned)
        target = np.where(pinned, v, qd + delta)
        v, blocked = _walk(v, target, sign, level, lower, upper, pinned)
        if blocked is not None:
            pinned[blocked] = True
            continue
        f = drive - A @ delta
        excess, way_out = _excess(v, f, level, lower, upper, pinned)
        worst = int(np.argmax(excess))
        if excess[worst] <= _ROUNDING * (size + np.abs(A * delta).max()):
            return delta, np.where(pinned, f, sign * level)
        pinned[worst], sign[worst] = False, way_out[worst]
    raise ArithmeticError('the resistance of the joints was not found')


def _best_on_face(A, drive, delta, pinned):
    """Return the best change with the pinned joints as they are and the resistance known."""
    if not pinned.any():
        return np.linalg.solve(A, drive)
    best = np.where(pinned, delta, 0.0)
    if not pinned.all():
        moving = ~pinned
        best[moving] = np.linalg.solve(A[np.ix_(moving, moving)], (drive - A @ best)[moving])
    return best


def _walk(v, target, sign, level, lower, upper, pinned):
    """Go from v towards the target up to the first kink; return where, and the joint there."""
    kink = np.where(target > upper, upper, np.where(target < lower, lower, target))
    kink = np.where((level > 0.0) & (sign * kink < 0.0), 0.0, kink)
    short = ~pinned & (kink != target)
    if not short.any():
        return target, None
    part = np.full(6, np.inf)
    part[short] = (kink - v)[short] / (target - v)[short]
    first = int(np.argmin(part))
    v = np.where(pinned, v, v + part[first] * (target - v))
    v[first] = kink[first]
    return v, first


def _excess(v, f, level, lower, upper, pinned):
    """Return by how much f leaves what a pinned joint allows, and the way it then moves."""
    # Moving backwards leaves a joint when f < least, forwards when f > most.
    least = np.where(v > 0.0, level, -level)
    most = np.where(v < 0.0, -level, level)
    back = np.where(pinned & (v > lower), least - f, 0.0)
    forth = np.where(pinned & (v < upper), f - most, 0.0)
    way_out = np.where(back > forth, -1.0, 1.0)
    moves = np.where(v == 0.0, way_out, np.sign(v))
    return np.maximum(back, forth), moves
