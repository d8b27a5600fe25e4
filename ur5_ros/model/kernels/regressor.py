"""Kernel of the regressor: what a unit of each inertial parameter takes, joint by joint."""

from math import isfinite

from ur5_ros.model.kernels.compiled import R1, R2, W2, inlined, kernel
from ur5_ros.model.kernels.newton_euler import NIL, Z
from ur5_ros.model.kernels.plane_geometry import add, add_scaled, cross, dot


@inlined
def column(t, row, j):
    """Return three numbers of a column of a pose."""
    return t[row, j], t[row + 1, j], t[row + 2, j]


@inlined
def minus(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def joint(t, row, j):
    """Return the axis of joint j and a point on it, in base."""
    if j == 0:
        return Z, NIL
    return column(t, row + 4 * j - 4, 2), column(t, row + 4 * j - 4, 3)


@inlined
def link_motion(motion, z, speed, gain, r):
    """Return (w, alpha, a) of a link's origin from those of the link before, in base."""
    w, alpha, a = motion
    alpha = add_scaled(add_scaled(alpha, speed, cross(w, z)), gain, z)
    w = add_scaled(w, speed, z)
    return w, alpha, add(a, add(cross(alpha, r), cross(w, cross(w, r))))


@inlined
def write_link(y, row, at, w, alpha, a, arm, z):
    """Write the ten numbers of a link on a joint; all vectors in axes of the link."""
    y[row, at] = dot(a, arm)
    # of m c: force alpha x c + w x (w x c), moment c x a
    for i in range(3):
        c = (1.0 * (i == 0), 1.0 * (i == 1), 1.0 * (i == 2))
        force = add(cross(alpha, c), cross(w, cross(w, c)))
        y[row, at + 1 + i] = dot(force, arm) + dot(cross(c, a), z)
    # of the tensor: moment I alpha + w x I w
    wz = cross(z, w)  # z . (w x I w) = (z x w) . I w
    y[row, at + 4] = z[0] * alpha[0] + wz[0] * w[0]
    y[row, at + 5] = (z[0] * alpha[1] + z[1] * alpha[0]) + (wz[0] * w[1] + wz[1] * w[0])
    y[row, at + 6] = z[1] * alpha[1] + wz[1] * w[1]
    y[row, at + 7] = (z[0] * alpha[2] + z[2] * alpha[0]) + (wz[0] * w[2] + wz[2] * w[0])
    y[row, at + 8] = (z[1] * alpha[2] + z[2] * alpha[1]) + (wz[1] * w[2] + wz[2] * w[1])
    y[row, at + 9] = z[2] * alpha[2] + wz[2] * w[2]


@inlined
def in_link(t, row, v):
    """Return a vector of the base in axes of a link."""
    return dot(column(t, row, 0), v), dot(column(t, row, 1), v), dot(column(t, row, 2), v)


@kernel(R2, R1, R1, R1, W2)
def regressor(t, qd, qdd, gravity, y):
    """Y of every state, (6, 60) each, from the poses of its links, (24, 4) each."""
    total = 0.0
    for n in range(qd.size // 6):
        row = 24 * n
        motion = NIL, NIL, (-gravity[0], -gravity[1], -gravity[2])
        for i in range(6):
            z, point = joint(t, row, i)
            pose = row + 4 * i
            origin = column(t, pose, 3)
            motion = link_motion(motion, z, qd[6 * n + i], qdd[6 * n + i], minus(origin, point))
            w, alpha, a = motion
            total += w[0] + w[1] + w[2] + a[0] + a[1] + a[2]
            w, alpha, a = in_link(t, pose, w), in_link(t, pose, alpha), in_link(t, pose, a)
            for j in range(6):
                if j > i:
                    for p in range(10):
                        y[6 * n + j, 10 * i + p] = 0.0
                else:
                    z, point = joint(t, row, j)
                    arm = cross(z, minus(origin, point))
                    write_link(y, 6 * n + j, 10 * i, w, alpha, a, in_link(t, pose, arm),
                               in_link(t, pose, z))
    return 0 if isfinite(total) else 1  # finite arguments alone come here
