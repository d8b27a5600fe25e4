"""Friction and the torque of a physics step, compiled."""

from math import exp, fabs, sqrt

import numpy as np

from ur5_ros.model.kernels.compiled import B1, R1, W1, W2, inlined, kernel

#: Faces of the problem that are tried at most; six joints need fewer than twenty.
_MOST_FACES = 1000
#: What rounding may do to a sum of torques, by the largest of them.
_ROUNDING = 1e-13
#: A joint this near to a stop touches it [rad]; rounding is a thousand times smaller.
STOP_TOLERANCE = 1e-12

#: A joint slower than this is at rest [rad/s], as in ``model.friction``.
_AT_REST = 1e-9

#: Where the constants have the stops, the length of the step and the parts of friction.
LOWER, UPPER, STEP_TIME, FRICTION = 6, 12, 18, 19

#: The row of the working space of :func:`solve_active_set` that says which joints are free.
FREE = 6

#: Codes of :func:`engine_torque` besides 0.
HELD, FAILED = 1, 2


@inlined
def factor(A, free, L):
    """Write Cholesky's factor of the free rows and columns of A (6, 6)."""
    for i in range(6):
        if free[i]:
            for j in range(i + 1):
                if free[j]:
                    rest = A[i, j]
                    for m in range(j):
                        if free[m]:
                            rest -= L[i, m] * L[j, m]
                    L[i, j] = sqrt(rest) if i == j else rest / L[j, j]


@inlined
def substitute(L, free, b, x):
    """Write x with L L^T x = b on the free joints; leave the others."""
    for i in range(6):
        if free[i]:
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
def line_search(v, target, free, sign, level, lower, upper):
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
def release_constraint(v, f, free, level, lower, upper):
    """Return the pinned joint whose f exceeds its bounds most, the excess, the direction."""
    worst, most, direction = 0, 0.0, 0.0
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
            direction = (-1.0 if back > forth else 1.0) if v[i] == 0.0 else np.sign(v[i])
    return worst, most, direction


@inlined
def solve_active_set(A, drive, qd, level, lower, upper, work, delta, f):
    """Write delta and f of ``solve_friction``; return 1 if they were not found."""
    L, free, sign, v, b, target = work[:6], work[FREE], work[7], work[8], work[9], work[10]
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
            delta[i], free[i] = -qd[i], 0.0
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
        factor(A, free, L)
        substitute(L, free, b, delta)
        for i in range(6):
            target[i] = qd[i] + delta[i]
        blocked = line_search(v, target, free, sign, level, lower, upper)
        if blocked >= 0:
            free[blocked] = 0.0
            continue
        for i in range(6):
            f[i] = drive[i]
            for j in range(6):
                f[i] -= A[i, j] * delta[j]
                largest = max(largest, fabs(A[i, j] * delta[j]))
        worst, excess, direction = release_constraint(v, f, free, level, lower, upper)
        if excess <= _ROUNDING * (size + strongest + largest):
            for i in range(6):
                if free[i]:
                    f[i] = sign[i] * level[i]
            return 0
        free[worst], sign[worst] = 1.0, direction
    return 1


@kernel(W2, W1, W1, W1, W1, W1, W2, W1, W1, hot=True)
def friction(A, drive, qd, level, lower, upper, work, delta, f):
    """Write delta and f of ``solve_friction``; return 1 if they were not found."""
    return solve_active_set(A, drive, qd, level, lower, upper, work, delta, f)


@inlined
def joint_friction(constants, i, qd, load):
    """Return damping, level and offset of joint i; see ``friction_terms``."""
    viscous, coulomb, excess, velocity, share, quadratic, cubic, warm, asymmetry = (
        constants[FRICTION + i], constants[FRICTION + 6 + i], constants[FRICTION + 12 + i],
        constants[FRICTION + 18 + i], constants[FRICTION + 24 + i], constants[FRICTION + 30 + i],
        constants[FRICTION + 36 + i], constants[FRICTION + 42 + i], constants[FRICTION + 48 + i])
    speed, level = fabs(qd), coulomb
    if excess > 0.0:
        ratio = qd / velocity
        level += excess * exp(-ratio * ratio)
    level = warm * (level + share * fabs(load))
    damping = max(viscous + speed * (quadratic + speed * cubic), 0.0)
    direction = 0.0 if speed < _AT_REST else np.sign(qd)
    return damping * (warm * (1.0 + asymmetry * direction)), level, asymmetry * level


@inlined
def prepare_step(state, constants, A, drive, lowest, highest, level):
    """Write the problem of a step: inertia by time, drive, speeds at the stops, dry friction."""
    h = constants[STEP_TIME]
    for i in range(6):
        q, qd, bias = state[42 + i], state[48 + i], state[36 + i]
        damping, level[i], offset = joint_friction(constants, i, qd, bias - state[60 + i])
        drive[i] = state[54 + i] - bias - damping * qd
        drive[i] -= offset
        lowest[i] = (constants[LOWER + i] - q) / h
        highest[i] = (constants[UPPER + i] - q) / h
        for j in range(6):
            A[i, j] = state[6 * i + j] / h
        A[i, i] += constants[i] + damping


@kernel(W1, R1, W2, W1, B1, hot=True)
def engine_torque(state, constants, work, torque, held):
    """Write the torque of ``PlantIntegrator.engine_torque`` and the joints held; return a code."""
    m, bias, q, qd = state[:36], state[36:42], state[42:48], state[48:54]
    lower, upper, h = constants[LOWER:UPPER], constants[UPPER:STEP_TIME], constants[STEP_TIME]
    A, drive, lowest, highest, level = work[:6], work[6], work[7], work[8], work[9]
    delta, f, solving = work[10], work[11], work[12:]
    prepare_step(state, constants, A, drive, lowest, highest, level)
    if solve_active_set(A, drive, qd, level, lowest, highest, solving, delta, f):
        return FAILED
    code = 0
    for i in range(6):
        reached = q[i] + h * (qd[i] + delta[i])
        held[i] = reached >= upper[i] - STOP_TOLERANCE or reached <= lower[i] + STOP_TOLERANCE
        if held[i]:
            code = HELD
        torque[i] = bias[i]
        for j in range(6):
            torque[i] += m[6 * i + j] * (delta[j] / h)
    return code
