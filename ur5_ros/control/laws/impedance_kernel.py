"""Cartesian impedance in one compiled call: tool, error, force, and the torque with its parts."""

from math import fabs, sqrt

import numpy as np

from ur5_ros.control.kernel import CORIOLIS, FEEDBACK, GRAVITY, INERTIAL, TOTAL
from ur5_ros.model.kernels.base_parameters import D1, D6, SIZE
from ur5_ros.model.kernels.compiled import R1, R2, W2, inlined, kernel
from ur5_ros.model.kernels.dynamics import terms_of_state
from ur5_ros.model.kernels.kinematics import (
    Y,
    directions,
    write_axis,
    write_pose,
    write_rate,
    write_vector,
)
from ur5_ros.model.kernels.newton_euler import NIL, Z, velocities
from ur5_ros.model.kernels.plane_geometry import add, add_scaled, axes, cross
from ur5_ros.model.kernels.trigonometry import arctangent, sine_cosine

#: What :func:`impedance_torque` comes to where the inverse of J has to be limited.
NEAR_SINGULAR = 1
#: Rows of the working space, six columns each.
WORK = 60


@inlined
def write_tool(q, qd, k, pose, J, rate):
    """Write pose (4, 4), Jacobian and dJ/dt (6, 6) of ``tool0``, in base, of one state."""
    turns, origins, lines = axes(q, 0, k)
    u3, u4, w5, u5, w6, u6 = lines
    s1, c1 = sine_cosine(q[0])
    p = add_scaled(origins[3], k[D6], w6)
    write_pose(pose, 0, c1, s1, directions(turns)[1], w6, p, k[D1])
    speeds = velocities(qd, 0, lines)
    pd = add(speeds[4][1], cross(speeds[4][0], p))
    write_axis(J, 0, 0, c1, s1, cross(Y, p), Y)
    write_axis(J, 0, 1, c1, s1, cross(Z, p), Z)
    write_axis(J, 0, 2, c1, s1, add(u3, cross(Z, p)), Z)
    write_axis(J, 0, 3, c1, s1, add(u4, cross(Z, p)), Z)
    write_axis(J, 0, 4, c1, s1, add(u5, cross(w5, p)), w5)
    write_axis(J, 0, 5, c1, s1, add(u6, cross(w6, p)), w6)
    write_vector(rate, 0, 0, c1, s1, cross(Y, pd))
    write_vector(rate, 3, 0, c1, s1, NIL)
    write_rate(rate, 0, 1, c1, s1, speeds[0], Z, NIL, p, pd)
    write_rate(rate, 0, 2, c1, s1, speeds[1], Z, u3, p, pd)
    write_rate(rate, 0, 3, c1, s1, speeds[2], Z, u4, p, pd)
    write_rate(rate, 0, 4, c1, s1, speeds[3], w5, u5, p, pd)
    write_rate(rate, 0, 5, c1, s1, speeds[4], w6, u6, p, pd)


@inlined
def turn_between(pose, target):
    """Return the rotation vector of R R*^T, by its quaternion, well conditioned at every angle."""
    a = (pose[0, 0], pose[0, 1], pose[0, 2])
    b = (pose[1, 0], pose[1, 1], pose[1, 2])
    c = (pose[2, 0], pose[2, 1], pose[2, 2])
    t0 = (target[0, 0], target[0, 1], target[0, 2])
    t1 = (target[1, 0], target[1, 1], target[1, 2])
    t2 = (target[2, 0], target[2, 1], target[2, 2])
    r = ((dot3(a, t0), dot3(a, t1), dot3(a, t2)), (dot3(b, t0), dot3(b, t1), dot3(b, t2)),
         (dot3(c, t0), dot3(c, t1), dot3(c, t2)))
    ww = 1.0 + r[0][0] + r[1][1] + r[2][2]
    xx = 1.0 + r[0][0] - r[1][1] - r[2][2]
    yy = 1.0 - r[0][0] + r[1][1] - r[2][2]
    zz = 1.0 - r[0][0] - r[1][1] + r[2][2]
    x, y, z, w = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1], ww
    if xx >= max(ww, yy, zz):
        x, y, z, w = xx, r[0][1] + r[1][0], r[0][2] + r[2][0], r[2][1] - r[1][2]
    elif yy >= max(ww, zz):
        x, y, z, w = r[0][1] + r[1][0], yy, r[1][2] + r[2][1], r[0][2] - r[2][0]
    elif zz >= ww:
        x, y, z, w = r[0][2] + r[2][0], r[1][2] + r[2][1], zz, r[1][0] - r[0][1]
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    size = sqrt(x * x + y * y + z * z)
    scale = 2.0 * arctangent(size, w) / size if size > 0.0 else 0.0
    return scale * x, scale * y, scale * z


@inlined
def dot3(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def write_inverse(J, A, inverse):
    """Write J^-1 (Gauss and Jordan, largest pivots); return its Frobenius norm."""
    for i in range(6):
        for j in range(6):
            A[i, j] = J[i, j]
            inverse[i, j] = 1.0 if i == j else 0.0
    for i in range(6):
        best = i
        for r in range(i + 1, 6):
            if fabs(A[r, i]) > fabs(A[best, i]):
                best = r
        if A[best, i] == 0.0:
            return np.inf
        for j in range(6):
            A[i, j], A[best, j] = A[best, j], A[i, j]
            inverse[i, j], inverse[best, j] = inverse[best, j], inverse[i, j]
        pivot = A[i, i]
        for j in range(6):
            A[i, j] /= pivot
            inverse[i, j] /= pivot
        for r in range(6):
            if r != i:
                share = A[r, i]
                for j in range(6):
                    A[r, j] -= share * A[i, j]
                    inverse[r, j] -= share * inverse[i, j]
    total = 0.0
    for i in range(6):
        for j in range(6):
            total += inverse[i, j] * inverse[i, j]
    return sqrt(total)


@inlined
def product(A, x, row, y):
    """Write y = A x, x a row of the working space."""
    for i in range(6):
        y[i] = 0.0
        for j in range(6):
            y[i] += A[i, j] * x[row, j]


@inlined
def turned(R, x, back, y):
    """Write both halves of x turned by R, or by its inverse."""
    for half in (0, 3):
        for i in range(3):
            y[half + i] = 0.0
            for j in range(3):
                y[half + i] += (R[j, i] if back else R[i, j]) * x[half + j]


@kernel(R1, R1, R1, R1, R1, R1, R2, R2, R2, R1, R1, W2, W2, W2, hot=True)
def impedance_torque(q, qd, q_ref, qd_ref, qdd_ref, k, stiffness, damping, softness, wrench,
                     switches, inverse, work, torque):
    """
    Write the rows of ``torque``, (5, 6); return NEAR_SINGULAR where J^-1 is too large.

    ``k`` is the packed arm and its angle offsets; ``softness`` is M_x^-1, used where the second
    switch is on; the first turns all three into the axes of the tool.  ``inverse`` becomes J^-1;
    where the third switch, the largest norm, is zero it is given.
    """
    angles, desired, e, v, a, f, x, y = (work[0], work[1], work[2], work[3], work[4], work[5],
                                         work[6], work[7])
    J, J_ref, rate, rate_ref = work[8:14], work[14:20], work[20:26], work[26:32]
    m, c, pose, target = work[32:38], work[38:44], work[44:48], work[48:52]
    for i in range(6):
        angles[i], desired[i] = q[i] + k[SIZE + i], q_ref[i] + k[SIZE + i]
    write_tool(angles, qd, k, pose, J, rate)
    write_tool(desired, qd_ref, k, target, J_ref, rate_ref)
    if switches[2] > 0.0 and not write_inverse(J, work[52:58], inverse) < switches[2]:
        return NEAR_SINGULAR
    e[3], e[4], e[5] = turn_between(pose, target)
    for i in range(6):
        if i < 3:
            e[i] = pose[i, 3] - target[i, 3]
        v[i] = a[i] = 0.0
        for j in range(6):
            v[i] += J[i, j] * qd[j] - J_ref[i, j] * qd_ref[j]
            a[i] += J_ref[i, j] * qdd_ref[j] + rate_ref[i, j] * qd_ref[j] - rate[i, j] * qd[j]
    in_tool = switches[0] > 0.0
    if in_tool:
        turned(pose, e, True, x)
        turned(pose, v, True, y)
        e, v = x, y
    for i in range(6):
        f[i] = 0.0
        for j in range(6):
            f[i] -= stiffness[i, j] * e[j] + damping[i, j] * v[j]
    if in_tool:
        turned(pose, f, False, work[58])
        f = work[58]
    for i in range(6):
        f[i] += wrench[i]
    g = torque[GRAVITY]
    terms_of_state(angles, qd, k, m, c, g, 0)
    product(inverse, work, 4, work[59])
    product(m, work, 59, torque[INERTIAL])
    if switches[1] > 0.0:
        shaped_feedback(pose, f, softness, in_tool, inverse, m, work, torque)
    for i in range(6):
        torque[CORIOLIS, i] = 0.0
        feedback = 0.0
        for j in range(6):
            torque[CORIOLIS, i] += c[i, j] * qd[j]
            feedback += J[j, i] * f[j]
        if not switches[1] > 0.0:
            torque[FEEDBACK, i] = feedback
        torque[TOTAL, i] = (torque[INERTIAL, i] + torque[FEEDBACK, i] + torque[CORIOLIS, i]
                            + g[i])
    return 0


@inlined
def shaped_feedback(pose, f, softness, in_tool, inverse, m, work, torque):
    """Write M J^-1 M_x^-1 F."""
    x, y = work[2], work[3]
    for i in range(6):
        x[i] = f[i]
    if in_tool:
        turned(pose, f, True, x)
    product(softness, work, 2, y)
    for i in range(6):
        x[i] = y[i]
    if in_tool:
        turned(pose, y, False, x)
    product(inverse, work, 2, y)
    product(m, work, 3, torque[FEEDBACK])
