"""
Kernels of the dynamics: M, C, g from composite moments, torque and acceleration from one pass.

Kinetic energy is T = sum of x' x' dm / 2, so M_ij = sum of d_i x . d_j x dm and the Christoffel
matrix is C_ij = sum of d_i x . (d_j x)' dm, with d_j x = w_j x x + u_j for the bodies beyond joint
j.  Only moments of the bodies appear: h = sum of x dm, E = sum of x x^T dm, p = sum of x' dm and
D = sum of x x'^T dm, added up from the tool to the shoulder.
"""

from math import isfinite, sqrt

import numpy as np

from ur5_ros.model.arm_plane import (
    add,
    add_scaled,
    axes,
    bodies,
    cross,
    dot,
    gravity_in_plane,
)
from ur5_ros.model.compiled import R1, W1, W2, inlined, kernel
from ur5_ros.model.lumped import ARMATURE, SHOULDER, SPIN

X = (1.0, 0.0, 0.0)
Z = (0.0, 0.0, 1.0)
NIL = (0.0, 0.0, 0.0)


@inlined
def moment(e, v):
    """Return I v, with the inertia tensor I = tr(E) 1 - E."""
    xx, xy, yy, xz, yz, zz = e
    return ((yy + zz) * v[0] - xy * v[1] - xz * v[2], (xx + zz) * v[1] - xy * v[0] - yz * v[2],
            (xx + yy) * v[2] - xz * v[0] - yz * v[1])


@inlined
def six(a, b):
    """Return the sum of two sets of second moments."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


@inlined
def momentum(h, e, w, u):
    """Return momentum and angular momentum of a composite that moves about one axis."""
    return cross(w, h), add(moment(e, w), cross(h, u))


@inlined
def flow(body, speed):
    """Return h, E, p and D (row by row) of a body that moves at (w, v)."""
    h, e = body
    w, v = speed
    xx, xy, yy, xz, yz, zz = e
    return (h, e, cross(w, h),
            (w[1] * xz - w[2] * xy + h[0] * v[0], w[2] * xx - w[0] * xz + h[0] * v[1],
             w[0] * xy - w[1] * xx + h[0] * v[2],
             w[1] * yz - w[2] * yy + h[1] * v[0], w[2] * xy - w[0] * yz + h[1] * v[1],
             w[0] * yy - w[1] * xy + h[1] * v[2],
             w[1] * zz - w[2] * yz + h[2] * v[0], w[2] * xz - w[0] * zz + h[2] * v[1],
             w[0] * yz - w[1] * xz + h[2] * v[2]))


@inlined
def joined(a, b):
    """Return h, E, p and D of two composites together."""
    d, f = a[3], b[3]
    return (add(a[0], b[0]), six(a[1], b[1]), add(a[2], b[2]),
            (d[0] + f[0], d[1] + f[1], d[2] + f[2], d[3] + f[3], d[4] + f[4], d[5] + f[5],
             d[6] + f[6], d[7] + f[7], d[8] + f[8]))


@inlined
def coriolis_force(h, e, p, d, axis, axis_rate):
    """Return force and moment of a composite for unit speed of one joint."""
    w, u = axis
    wd, ud = axis_rate
    trace = d[0] + d[4] + d[8]
    g = (trace * w[0] - d[0] * w[0] - d[3] * w[1] - d[6] * w[2],
         trace * w[1] - d[1] * w[0] - d[4] * w[1] - d[7] * w[2],
         trace * w[2] - d[2] * w[0] - d[5] * w[1] - d[8] * w[2])
    return (add(cross(wd, h), cross(w, p)),
            add(add(moment(e, wd), cross(h, ud)), g))


@inlined
def coriolis_row(p, d, w, u):
    """Return the vector whose product with w_j is the moving part of C_ij, j < i."""
    trace = d[0] + d[4] + d[8]
    g = (trace * w[0] - d[0] * w[0] - d[1] * w[1] - d[2] * w[2],
         trace * w[1] - d[3] * w[0] - d[4] * w[1] - d[5] * w[2],
         trace * w[2] - d[6] * w[0] - d[7] * w[1] - d[8] * w[2])
    return add(g, cross(p, u))


@inlined
def rates(speed, axis_w, axis_u):
    """Return the rate of change of an axis (w, u) that is carried along at (w, v)."""
    w, v = speed
    return cross(w, axis_w), add(cross(w, axis_u), cross(v, axis_w))


@inlined
def velocities(qd, at, lines):
    """Return the velocities (w, v) of links 2 to 6."""
    u3, u4, w5, u5, w6, u6 = lines
    qd1, qd5, qd6 = qd[at], qd[at + 4], qd[at + 5]
    w2 = (0.0, qd1, qd[at + 1])
    w3 = (0.0, qd1, w2[2] + qd[at + 2])
    w4 = (0.0, qd1, w3[2] + qd[at + 3])
    w5 = add_scaled(w4, qd5, w5)
    v3 = (qd[at + 2] * u3[0], qd[at + 2] * u3[1], 0.0)
    v4 = add_scaled(v3, qd[at + 3], u4)
    v5 = add_scaled(v4, qd5, u5)
    return ((w2, NIL), (w3, v3), (w4, v4), (w5, v5),
            (add_scaled(w5, qd6, w6), add_scaled(v5, qd6, u6)))


@inlined
def finite(x, at):
    """Tell whether the six numbers from ``at`` on are finite."""
    return isfinite(x[at] + x[at + 1] + x[at + 2] + x[at + 3] + x[at + 4] + x[at + 5])


@inlined
def joint(at, j, composite, axis, axis_rate, lines, line_rates, a, m, c, g):
    """Write what the composite of links j + 1 to 6 adds: M, C and g with j the larger index."""
    h, e, p, d = composite
    w, u = axis
    u3, u4, w5, u5, w6, u6 = lines
    wd, ud3, ud4, wd5, ud5 = line_rates
    f, n = momentum(h, e, w, u)
    g[at + j] = -dot(a, f)
    write_column(m, at, j, f, n, lines)
    mf, mn = coriolis_force(h, e, p, d, axis, axis_rate)
    write_column(c, at, j, mf, mn, lines)
    r = coriolis_row(p, d, w, u)
    c[at + j, 0] = r[1]
    if j > 1:
        c[at + j, 1] = n[0] * wd + r[2]
    if j > 2:
        c[at + j, 2] = n[0] * wd + dot(f, ud3) + r[2]
    if j > 3:
        c[at + j, 3] = n[0] * wd + dot(f, ud4) + r[2]
    if j > 4:
        c[at + j, 4] = dot(n, wd5) + dot(f, ud5) + dot(r, w5)


@inlined
def write_column(out, at, j, f, n, lines):
    """Write the products of axes 1 to j + 1 with the wrench (f, n) as column j."""
    u3, u4, w5, u5, w6, u6 = lines
    out[at, j] = n[1]
    out[at + 1, j] = n[2]
    if j > 1:
        out[at + 2, j] = n[2] + u3[0] * f[0] + u3[1] * f[1]
    if j > 2:
        out[at + 3, j] = n[2] + u4[0] * f[0] + u4[1] * f[1]
    if j > 3:
        out[at + 4, j] = w5[0] * n[0] + w5[1] * n[1] + dot(u5, f)
    if j > 4:
        out[at + 5, j] = dot(w6, n) + dot(u6, f)


@inlined
def mirror(m, at, k):
    """Copy the upper triangle to the lower and add the rotor inertia."""
    for i in range(6):
        m[at + i, i] += k[ARMATURE + i]
        for j in range(i):
            m[at + i, j] = m[at + j, i]


@kernel(R1, R1, R1, W2, W2, W1)
def terms(q, qd, k, m, c, g):
    """M, C and g of every state."""
    if q.size != g.size or qd.size != g.size:
        return 1
    for at in range(0, g.size, 6):
        if not (finite(q, at) and finite(qd, at)):
            return 1
        turns, origins, lines = axes(q, at, k)
        u3, u4, w5, u5, w6, u6 = lines
        b2, b3, b4, b5, b6 = bodies(turns, origins, k)
        s2, s3, s4, s5, s6 = velocities(qd, at, lines)
        r3, r4, r5, r6 = rates(s3, Z, u3), rates(s4, Z, u4), rates(s5, w5, u5), rates(s6, w6, u6)
        line_rates = qd[at], r3[1], r4[1], r5[0], r5[1]
        a = gravity_in_plane(q[at], k)
        whole = flow(b6, s6)
        joint(at, 5, whole, (w6, u6), r6, lines, line_rates, a, m, c, g)
        whole = joined(whole, flow(b5, s5))
        joint(at, 4, whole, (w5, u5), r5, lines, line_rates, a, m, c, g)
        whole = joined(whole, flow(b4, s4))
        joint(at, 3, whole, (Z, u4), r4, lines, line_rates, a, m, c, g)
        whole = joined(whole, flow(b3, s3))
        joint(at, 2, whole, (Z, u3), r3, lines, line_rates, a, m, c, g)
        h, e, p, d = joined(whole, flow(b2, s2))
        joint(at, 1, (h, e, p, d), (Z, NIL), ((qd[at], 0.0, 0.0), NIL), lines, line_rates, a, m,
              c, g)
        m[at, 0] = e[0] + e[5] + k[SPIN]
        c[at, 0] = d[0] + d[8]
        g[at] = a[0] * (h[2] + k[SHOULDER + 3]) - a[2] * (h[0] + k[SHOULDER + 1])
        g[at] = -g[at]
        mirror(m, at, k)
    return 0


@inlined
def write_inertia(m, at, bodies_in_plane, lines, k):
    """Write M of one state."""
    (h2, e2), (h3, e3), (h4, e4), (h5, e5), (h6, e6) = bodies_in_plane
    u3, u4, w5, u5, w6, u6 = lines
    f, n = momentum(h6, e6, w6, u6)
    write_column(m, at, 5, f, n, lines)
    h, e = add(h5, h6), six(e5, e6)
    f, n = momentum(h, e, w5, u5)
    write_column(m, at, 4, f, n, lines)
    h, e = add(h, h4), six(e, e4)
    f, n = momentum(h, e, Z, u4)
    write_column(m, at, 3, f, n, lines)
    h, e = add(h, h3), six(e, e3)
    f, n = momentum(h, e, Z, u3)
    write_column(m, at, 2, f, n, lines)
    h, e = add(h, h2), six(e, e2)
    f, n = momentum(h, e, Z, NIL)
    write_column(m, at, 1, f, n, lines)
    m[at, 0] = e[0] + e[5] + k[SPIN]
    mirror(m, at, k)


@kernel(R1, R1, W2)
def inertia(q, k, m):
    """M of every state."""
    if m.shape[0] != q.size:
        return 1
    for at in range(0, q.size, 6):
        if not finite(q, at):
            return 1
        turns, origins, lines = axes(q, at, k)
        write_inertia(m, at, bodies(turns, origins, k), lines, k)
    return 0


@kernel(R1, R1, W1)
def gravity(q, k, g):
    """Holding torque of every state."""
    if q.size != g.size:
        return 1
    for at in range(0, g.size, 6):
        if not finite(q, at):
            return 1
        turns, origins, lines = axes(q, at, k)
        u3, u4, w5, u5, w6, u6 = lines
        (h2, _), (h3, _), (h4, _), (h5, _), (h6, _) = bodies(turns, origins, k)
        a = gravity_in_plane(q[at], k)
        g[at + 5] = -dot(a, cross(w6, h6))
        h = add(h5, h6)
        g[at + 4] = -dot(a, cross(w5, h))
        h = add(h, h4)
        g[at + 3] = a[0] * h[1] - a[1] * h[0]
        h = add(h, h3)
        g[at + 2] = a[0] * h[1] - a[1] * h[0]
        h = add(h, h2)
        g[at + 1] = a[0] * h[1] - a[1] * h[0]
        g[at] = a[2] * (h[0] + k[SHOULDER + 1]) - a[0] * (h[2] + k[SHOULDER + 3])
    return 0


@inlined
def newton_euler(body, speed, acceleration):
    """Return force and moment that a body takes; acceleration is that of the point at rest."""
    h, e = body
    w, v = speed
    alpha, beta = acceleration
    force = add(cross(alpha, h), cross(w, cross(w, h)))
    spin = add(moment(e, alpha), cross(w, moment(e, w)))
    return force, add(spin, cross(h, add(beta, cross(w, v))))


@inlined
def accelerated(acceleration, rate, qd, qdd, axis):
    """Return the acceleration beyond a joint."""
    alpha, beta = acceleration
    wd, ud = rate
    w, u = axis
    return (add_scaled(add_scaled(alpha, qd, wd), qdd, w),
            add_scaled(add_scaled(beta, qd, ud), qdd, u))


@inlined
def torque_of_motion(bodies_in_plane, lines, qd, qdd, at, a, k):
    """Return the six joint torques of a motion, without the rotors."""
    u3, u4, w5, u5, w6, u6 = lines
    b2, b3, b4, b5, b6 = bodies_in_plane
    s2, s3, s4, s5, s6 = velocities(qd, at, lines)
    a2 = ((qd[at] * qd[at + 1], qdd[at], qdd[at + 1]), (-a[0], -a[1], -a[2]))
    a3 = accelerated(a2, rates(s3, Z, u3), qd[at + 2], qdd[at + 2], (Z, u3))
    a4 = accelerated(a3, rates(s4, Z, u4), qd[at + 3], qdd[at + 3], (Z, u4))
    a5 = accelerated(a4, rates(s5, w5, u5), qd[at + 4], qdd[at + 4], (w5, u5))
    a6 = accelerated(a5, rates(s6, w6, u6), qd[at + 5], qdd[at + 5], (w6, u6))
    f, n = newton_euler(b6, s6, a6)
    t6 = dot(w6, n) + dot(u6, f)
    f5, n5 = newton_euler(b5, s5, a5)
    f, n = add(f, f5), add(n, n5)
    t5 = dot(w5, n) + dot(u5, f)
    f4, n4 = newton_euler(b4, s4, a4)
    f, n = add(f, f4), add(n, n4)
    t4 = n[2] + dot(u4, f)
    f3, n3 = newton_euler(b3, s3, a3)
    f, n = add(f, f3), add(n, n3)
    t3 = n[2] + dot(u3, f)
    f2, n2 = newton_euler(b2, s2, a2)
    n = add(n, n2)
    t1 = (n[1] + k[SPIN] * qdd[at]
          + a[2] * k[SHOULDER + 1] - a[0] * k[SHOULDER + 3])
    return t1, n[2], t3, t4, t5, t6


@kernel(R1, R1, R1, R1, W1)
def inverse(q, qd, qdd, k, tau):
    """Joint torque of every state of motion."""
    if q.size != tau.size or qd.size != tau.size or qdd.size != tau.size:
        return 1
    for at in range(0, tau.size, 6):
        if not (finite(q, at) and finite(qd, at) and finite(qdd, at)):
            return 1
        turns, origins, lines = axes(q, at, k)
        t1, t2, t3, t4, t5, t6 = torque_of_motion(
            bodies(turns, origins, k), lines, qd, qdd, at, gravity_in_plane(q[at], k), k)
        tau[at] = t1 + k[ARMATURE] * qdd[at]
        tau[at + 1] = t2 + k[ARMATURE + 1] * qdd[at + 1]
        tau[at + 2] = t3 + k[ARMATURE + 2] * qdd[at + 2]
        tau[at + 3] = t4 + k[ARMATURE + 3] * qdd[at + 3]
        tau[at + 4] = t5 + k[ARMATURE + 4] * qdd[at + 4]
        tau[at + 5] = t6 + k[ARMATURE + 5] * qdd[at + 5]
    return 0


@inlined
def solve(m, x, at):
    """Overwrite six numbers of x with m^-1 x by Cholesky, and m (6, 6) with its factor."""
    for j in range(6):
        for i in range(j):
            m[j, j] -= m[j, i] * m[j, i]
        if not m[j, j] > 0.0:
            return False
        m[j, j] = sqrt(m[j, j])
        for r in range(j + 1, 6):
            for i in range(j):
                m[r, j] -= m[r, i] * m[j, i]
            m[r, j] /= m[j, j]
    for r in range(6):
        for i in range(r):
            x[at + r] -= m[r, i] * x[at + i]
        x[at + r] /= m[r, r]
    for r in range(5, -1, -1):
        for i in range(r + 1, 6):
            x[at + r] -= m[i, r] * x[at + i]
        x[at + r] /= m[r, r]
    return True


@kernel(R1, R1, R1, R1, W1)
def forward(q, qd, tau, k, qdd):
    """Joint acceleration of every state under torque."""
    if q.size != qdd.size or qd.size != qdd.size or tau.size != qdd.size:
        return 1
    m = np.empty((6, 6))
    for at in range(0, tau.size, 6):
        if not (finite(q, at) and finite(qd, at) and finite(tau, at)):
            return 1
        turns, origins, lines = axes(q, at, k)
        in_plane = bodies(turns, origins, k)
        write_inertia(m, 0, in_plane, lines, k)
        for i in range(6):
            qdd[at + i] = 0.0
        t1, t2, t3, t4, t5, t6 = torque_of_motion(
            in_plane, lines, qd, qdd, at, gravity_in_plane(q[at], k), k)
        qdd[at] = tau[at] - t1
        qdd[at + 1] = tau[at + 1] - t2
        qdd[at + 2] = tau[at + 2] - t3
        qdd[at + 3] = tau[at + 3] - t4
        qdd[at + 4] = tau[at + 4] - t5
        qdd[at + 5] = tau[at + 5] - t6
        if not solve(m, qdd, at):
            return 2
    return 0
