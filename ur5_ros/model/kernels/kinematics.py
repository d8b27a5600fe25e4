"""Kernels of the kinematics: poses and Jacobians from the axes in the plane of the arm."""

from math import isfinite

from ur5_ros.model.kernels.base_parameters import D1, D6
from ur5_ros.model.kernels.compiled import R1, W2, inlined, kernel
from ur5_ros.model.kernels.newton_euler import NIL, Z, rates, velocities
from ur5_ros.model.kernels.plane_geometry import add, add_scaled, axes, cross, total
from ur5_ros.model.kernels.trigonometry import sine_cosine

Y = (0.0, 1.0, 0.0)


@inlined
def write_vector(out, row, column, c1, s1, v):
    """Write a vector of frame 1 in axes of the base."""
    out[row, column] = c1 * v[0] + s1 * v[2]
    out[row + 1, column] = s1 * v[0] - c1 * v[2]
    out[row + 2, column] = v[1]


@inlined
def write_pose(out, row, c1, s1, x, z, p, d1):
    """Write the pose with axes x, y = z x x, z and origin p, all given in frame 1."""
    write_vector(out, row, 0, c1, s1, x)
    write_vector(out, row, 1, c1, s1, cross(z, x))
    write_vector(out, row, 2, c1, s1, z)
    write_vector(out, row, 3, c1, s1, p)
    out[row + 2, 3] += d1
    out[row + 3, 0] = 0.0
    out[row + 3, 1] = 0.0
    out[row + 3, 2] = 0.0
    out[row + 3, 3] = 1.0


@inlined
def directions(turns):
    """Return the x axes of frames 5 and 6."""
    c2, s2, c23, s23, c234, s234, c5, s5, c6, s6 = turns
    x5 = (c5 * c234, c5 * s234, s5)
    return x5, (c6 * x5[0] - s6 * s234, c6 * x5[1] + s6 * c234, c6 * s5)


@inlined
def is_finite(turns, c1, numbers):
    """Return whether the numbers are finite and no angle is too large for its cosine."""
    c2, s2, c23, s23, c234, s234, c5, s5, c6, s6 = turns
    return isfinite(numbers + c1 + c2 + c23 + c234 + c5 + c6)


@kernel(R1, R1, W2, hot=True)
def pose(q, k, t):
    """Pose of the flange for every configuration."""
    if 4 * q.size != 6 * t.shape[0]:
        return 1
    for i in range(q.size // 6):
        turns, origins, lines = axes(q, 6 * i, k)
        s1, c1 = sine_cosine(q[6 * i])
        if not is_finite(turns, c1, total(q, 6 * i)):
            return 1
        w6 = lines[4]
        write_pose(t, 4 * i, c1, s1, directions(turns)[1], w6,
                   add_scaled(origins[3], k[D6], w6), k[D1])
    return 0


@kernel(R1, R1, W2)
def links(q, k, t):
    """Poses of the six link frames for every configuration."""
    if 4 * q.size != t.shape[0]:
        return 1
    for i in range(q.size // 6):
        turns, origins, lines = axes(q, 6 * i, k)
        o2, o3, o4, o5 = origins
        c2, s2, c23, s23, c234, s234, c5, s5, c6, s6 = turns
        s1, c1 = sine_cosine(q[6 * i])
        if not is_finite(turns, c1, total(q, 6 * i)):
            return 1
        x5, x6 = directions(turns)
        w5, w6 = lines[2], lines[4]
        row = 24 * i
        write_pose(t, row, c1, s1, (1.0, 0.0, 0.0), Z, NIL, k[D1])
        write_pose(t, row + 4, c1, s1, (c2, s2, 0.0), Z, o2, k[D1])
        write_pose(t, row + 8, c1, s1, (c23, s23, 0.0), Z, o3, k[D1])
        write_pose(t, row + 12, c1, s1, (c234, s234, 0.0), w5, o4, k[D1])
        write_pose(t, row + 16, c1, s1, x5, w6, o5, k[D1])
        write_pose(t, row + 20, c1, s1, x6, w6, add_scaled(o5, k[D6], w6), k[D1])
    return 0


@inlined
def write_axis(out, row, j, c1, s1, linear, angular):
    """Write one column of a Jacobian."""
    write_vector(out, row, j, c1, s1, linear)
    write_vector(out, row + 3, j, c1, s1, angular)


@kernel(R1, R1, W2, hot=True)
def jacobian(q, k, out):
    """Geometric Jacobian of the flange for every configuration."""
    if q.size != out.shape[0]:
        return 1
    for at in range(0, q.size, 6):
        turns, origins, lines = axes(q, at, k)
        u3, u4, w5, u5, w6, u6 = lines
        s1, c1 = sine_cosine(q[at])
        if not is_finite(turns, c1, total(q, at)):
            return 1
        p = add_scaled(origins[3], k[D6], w6)
        write_axis(out, at, 0, c1, s1, cross(Y, p), Y)
        write_axis(out, at, 1, c1, s1, cross(Z, p), Z)
        write_axis(out, at, 2, c1, s1, add(u3, cross(Z, p)), Z)
        write_axis(out, at, 3, c1, s1, add(u4, cross(Z, p)), Z)
        write_axis(out, at, 4, c1, s1, add(u5, cross(w5, p)), w5)
        write_axis(out, at, 5, c1, s1, add(u6, cross(w6, p)), w6)
    return 0


@kernel(R1, R1, R1, W2)
def jacobian_rate(q, qd, k, out):
    """Time derivative of the Jacobian for every state."""
    if q.size != out.shape[0] or qd.size != out.shape[0]:
        return 1
    for at in range(0, q.size, 6):
        turns, origins, lines = axes(q, at, k)
        u3, u4, w5, u5, w6, u6 = lines
        s1, c1 = sine_cosine(q[at])
        if not is_finite(turns, c1, total(q, at) + total(qd, at)):
            return 1
        p = add_scaled(origins[3], k[D6], w6)
        speeds = velocities(qd, at, lines)
        pd = add(speeds[4][1], cross(speeds[4][0], p))
        write_axis(out, at, 0, c1, s1, cross(Y, pd), NIL)
        write_rate(out, at, 1, c1, s1, speeds[0], Z, NIL, p, pd)
        write_rate(out, at, 2, c1, s1, speeds[1], Z, u3, p, pd)
        write_rate(out, at, 3, c1, s1, speeds[2], Z, u4, p, pd)
        write_rate(out, at, 4, c1, s1, speeds[3], w5, u5, p, pd)
        write_rate(out, at, 5, c1, s1, speeds[4], w6, u6, p, pd)
    return 0


@inlined
def write_rate(out, row, j, c1, s1, speed, w, u, p, pd):
    """Write the rate of change of one column."""
    wd, ud = rates(speed, w, u)
    write_axis(out, row, j, c1, s1, add(add(ud, cross(wd, p)), cross(w, pd)), wd)
