"""Dry friction, brakes and stops at the new velocity: one convex problem, solved exactly."""

from math import fabs, sqrt

import numpy as np

from ur5_ros.model.compiled import R1, R2, W1, inlined, kernel

#: Faces of the problem that are tried at most; six joints need fewer than twenty.
_MOST_FACES = 1000
#: What rounding may do to a sum of torques, by the largest of them.
_ROUNDING = 1e-13
#: Length of the working space.
WORK = 66


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
    delta, f = np.empty(6), np.empty(6)
    if resisted.run(1, [], [A, drive, qd, level, lower, upper, np.empty(WORK)], [delta, f]):
        raise ArithmeticError('the resistance of the joints was not found')
    return delta, f


@inlined
def solve(A, b, free, L, x):
    """Write x with A x = b on the free joints, by Cholesky's decomposition; leave the others."""
    for i in range(6):
        if not free[i]:
            continue
        for j in range(i + 1):
            if not free[j]:
                continue
            rest = A[i, j]
            for m in range(j):
                if free[m]:
                    rest -= L[i, m] * L[j, m]
            L[i, j] = sqrt(rest) if i == j else rest / L[j, j]
        rest = b[i]
        for m in range(i):
            if free[m]:
                rest -= L[i, m] * x[m]
        x[i] = rest / L[i, i]
    for i in range(5, -1, -1):
        if free[i]:
            for m in range(i + 1, 6):
                if free[m]:
                    x[i] -= L[m, i] * x[m]
            x[i] /= L[i, i]


@inlined
def walk(v, target, free, sign, level, lower, upper):
    """Go from v towards the target up to the first kink; return the joint there, -1 if none."""
    first, part, place = -1, 0.0, 0.0
    for i in range(6):
        kink = min(max(target[i], lower[i]), upper[i])
        if level[i] > 0.0 and sign[i] * kink < 0.0:
            kink = 0.0
        if free[i] and kink != target[i]:
            share = (kink - v[i]) / (target[i] - v[i])
            if first < 0 or share < part:
                first, part, place = i, share, kink
    for i in range(6):
        if free[i]:
            v[i] = target[i] if first < 0 else v[i] + part * (target[i] - v[i])
    if first >= 0:
        v[first] = place
    return first


@inlined
def release(v, f, free, level, lower, upper):
    """Return the pinned joint whose f leaves most what it allows, by how much, and its way out."""
    worst, most, way = 0, 0.0, 0.0
    for i in range(6):
        if free[i]:
            continue
        back = forth = 0.0
        if v[i] > lower[i]:  # moving backwards leaves it when f is less than this
            back = (level[i] if v[i] > 0.0 else -level[i]) - f[i]
        if v[i] < upper[i]:  # and forwards when f is more than this
            forth = f[i] - (-level[i] if v[i] < 0.0 else level[i])
        excess = max(back, forth)
        if excess > most or excess != excess:
            worst, most = i, excess
            way = (-1.0 if back > forth else 1.0) if v[i] == 0.0 else np.sign(v[i])
    return worst, most, way


@inlined
def resist(A, drive, qd, level, lower, upper, work, delta, f):
    """Write delta and f of :func:`resisted_change`; return 1 if they were not found."""
    L = work[:36].reshape((6, 6))
    free, sign, v = work[36:42], work[42:48], work[48:54]
    b, target = work[54:60], work[60:66]
    size, dry, rest = 0.0, False, True
    for i in range(6):
        dry |= level[i] > 0.0
        f[i] = drive[i]  # and A qd: what it takes to stop every joint at once
        for j in range(6):
            f[i] += A[i, j] * qd[j]
        rest &= fabs(f[i]) <= level[i] and lower[i] <= 0.0 <= upper[i]
        size = max(size, fabs(drive[i]))
    if dry and rest:
        for i in range(6):
            delta[i] = -qd[i]
        return 0
    strongest = 0.0
    for i in range(6):
        strongest = max(strongest, level[i])
        slow = fabs(A[i, i] * qd[i]) < level[i]  # held, as a first guess
        v[i] = min(max(0.0 if slow else qd[i], lower[i]), upper[i])
        sign[i] = np.sign(v[i])
        pinned = v[i] <= lower[i] or v[i] >= upper[i] or (v[i] == 0.0 and level[i] > 0.0)
        free[i] = 0.0 if pinned else 1.0
    for _ in range(_MOST_FACES):
        largest = 0.0
        for i in range(6):  # the best of the face: what is pinned stays, resistance is known
            delta[i] = v[i] - qd[i]
            b[i] = drive[i] - sign[i] * level[i]
        for i in range(6):
            for j in range(6):
                if not free[j]:
                    b[i] -= A[i, j] * delta[j]
        solve(A, b, free, L, delta)
        for i in range(6):
            target[i] = qd[i] + delta[i]
        blocked = walk(v, target, free, sign, level, lower, upper)
        if blocked >= 0:
            free[blocked] = 0.0
            continue
        for i in range(6):
            f[i] = drive[i]
            for j in range(6):
                f[i] -= A[i, j] * delta[j]
                largest = max(largest, fabs(A[i, j] * delta[j]))
        worst, excess, way = release(v, f, free, level, lower, upper)
        if excess <= _ROUNDING * (size + strongest + largest):
            for i in range(6):
                if free[i]:
                    f[i] = sign[i] * level[i]
            return 0
        free[worst], sign[worst] = 1.0, way
    return 1


@kernel(R2, R1, R1, R1, R1, R1, W1, W1, W1)
def resisted(A, drive, qd, level, lower, upper, work, delta, f):
    """Write delta and f of :func:`resisted_change`; return 1 if they were not found."""
    return resist(A, drive, qd, level, lower, upper, work, delta, f)
