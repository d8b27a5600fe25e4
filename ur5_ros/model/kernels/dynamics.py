"""Kernels of the dynamics: M, C, g from composite moments, and the torque in one pass."""

from math import isfinite

from ur5_ros.model.kernels.base_parameters import ARMATURE, SHOULDER, SPIN
from ur5_ros.model.kernels.compiled import R1, W1, W2, inlined, kernel
from ur5_ros.model.kernels.composite_inertia import (
    column,
    coriolis_force,
    coriolis_row,
    flow,
    joined,
    momentum,
    six,
)
from ur5_ros.model.kernels.newton_euler import NIL, Z, rates, torque_of_motion, velocities
from ur5_ros.model.kernels.plane_geometry import (
    add,
    axes,
    bodies,
    cross,
    dot,
    gravity_in_plane,
    total,
)


@inlined
def write_column(out, at, j, entries):
    """Write the entries 1 to j + 1 of column j."""
    out[at, j] = entries[0]
    out[at + 1, j] = entries[1]
    if j > 1:
        out[at + 2, j] = entries[2]
    if j > 2:
        out[at + 3, j] = entries[3]
    if j > 3:
        out[at + 4, j] = entries[4]
    if j > 4:
        out[at + 5, j] = entries[5]


@inlined
def write_row(out, at, i, entries):
    """Write the entries 1 to i of row i, left of the diagonal."""
    out[at + i, 0] = entries[0]
    if i > 1:
        out[at + i, 1] = entries[1]
    if i > 2:
        out[at + i, 2] = entries[2]
    if i > 3:
        out[at + i, 3] = entries[3]
    if i > 4:
        out[at + i, 4] = entries[4]


@inlined
def write_mass(m, at, j, entries, k):
    """Write column and row j of M, the rotor on the diagonal."""
    write_column(m, at, j, entries)
    write_row(m, at, j, entries)
    m[at + j, j] = entries[j] + k[ARMATURE + j]


@inlined
def joint(at, j, composite, axis, axis_rate, lines, line_rates, a, k, m, c, g):
    """Write what the composite of links j + 1 to 6 adds: M, C and g with j the larger index."""
    h, e, p, d = composite
    w, u = axis
    wd2, ud3, ud4, wd5, ud5 = line_rates
    f, n = momentum(h, e, w, u)
    g[at + j] = -dot(a, f)
    write_mass(m, at, j, column(f, n, lines), k)
    mf, mn = coriolis_force(h, e, p, d, axis, axis_rate)
    write_column(c, at, j, column(mf, mn, lines))
    r = coriolis_row(p, d, w, u)
    turn = n[0] * wd2 + r[2]  # axes 2, 3 and 4 turn alike
    write_row(c, at, j, (r[1], turn, turn + dot(f, ud3), turn + dot(f, ud4),
                         dot(n, wd5) + dot(f, ud5) + dot(r, lines[2])))


@inlined
def terms_of_state(q, qd, k, m, c, g, at):
    """Write M, C and g of one state; return a number that is finite if all went well."""
    turns, origins, lines = axes(q, at, k)
    u3, u4, w5, u5, w6, u6 = lines
    b2, b3, b4, b5, b6 = bodies(turns, origins, k)
    s2, s3, s4, s5, s6 = velocities(qd, at, lines)
    r3, r4, r5, r6 = rates(s3, Z, u3), rates(s4, Z, u4), rates(s5, w5, u5), rates(s6, w6, u6)
    moved = qd[at], r3[1], r4[1], r5[0], r5[1]
    a = gravity_in_plane(q[at], k)
    whole = flow(b6, s6)
    joint(at, 5, whole, (w6, u6), r6, lines, moved, a, k, m, c, g)
    whole = joined(whole, flow(b5, s5))
    joint(at, 4, whole, (w5, u5), r5, lines, moved, a, k, m, c, g)
    whole = joined(whole, flow(b4, s4))
    joint(at, 3, whole, (Z, u4), r4, lines, moved, a, k, m, c, g)
    whole = joined(whole, flow(b3, s3))
    joint(at, 2, whole, (Z, u3), r3, lines, moved, a, k, m, c, g)
    whole = joined(whole, flow(b2, s2))
    r2 = ((qd[at], 0.0, 0.0), NIL)
    joint(at, 1, whole, (Z, NIL), r2, lines, moved, a, k, m, c, g)
    h, e, p, d = whole
    m[at, 0] = e[0] + e[5] + k[SPIN] + k[ARMATURE]
    c[at, 0] = d[0] + d[8]
    g[at] = a[2] * (h[0] + k[SHOULDER + 1]) - a[0] * (h[2] + k[SHOULDER + 3])
    return total(qd, at) + total(g, at) + d[0] + d[4] + d[8] + dot(p, p)


@kernel(R1, R1, R1, W2, W2, W1, hot=True)
def terms(q, qd, k, m, c, g):
    """M, C and g of every state."""
    if q.size != g.size or qd.size != g.size:
        return 1
    for at in range(0, g.size, 6):
        if not isfinite(terms_of_state(q, qd, k, m, c, g, at)):
            return 1
    return 0


@inlined
def mass_column(h, e, w, u, lines):
    """Return a column of M from the composite of the links beyond its joint."""
    f, n = momentum(h, e, w, u)
    return column(f, n, lines)


@inlined
def mass_columns(bodies_in_plane, lines, k):
    """Return the columns of M of one state, each down to the diagonal, and M11."""
    (h2, e2), (h3, e3), (h4, e4), (h5, e5), (h6, e6) = bodies_in_plane
    u3, u4, w5, u5, w6, u6 = lines
    c6 = mass_column(h6, e6, w6, u6, lines)
    h, e = add(h5, h6), six(e5, e6)
    c5 = mass_column(h, e, w5, u5, lines)
    h, e = add(h, h4), six(e, e4)
    c4 = mass_column(h, e, Z, u4, lines)
    h, e = add(h, h3), six(e, e3)
    c3 = mass_column(h, e, Z, u3, lines)
    h, e = add(h, h2), six(e, e2)
    c2 = mass_column(h, e, Z, NIL, lines)
    return e[0] + e[5] + k[SPIN] + k[ARMATURE], c2, c3, c4, c5, c6


@kernel(R1, R1, W2, hot=True)
def inertia(q, k, m):
    """M of every state."""
    if m.shape[0] != q.size:
        return 1
    for at in range(0, q.size, 6):
        turns, origins, lines = axes(q, at, k)
        m11, c2, c3, c4, c5, c6 = mass_columns(bodies(turns, origins, k), lines, k)
        m[at, 0] = m11
        write_mass(m, at, 1, c2, k)
        write_mass(m, at, 2, c3, k)
        write_mass(m, at, 3, c4, k)
        write_mass(m, at, 4, c5, k)
        write_mass(m, at, 5, c6, k)
        if not isfinite(q[at] + m11 + c5[4] + c6[5] + c6[0]):
            return 1
    return 0


@kernel(R1, R1, W1, hot=True)
def gravity(q, k, g):
    """Holding torque of every state."""
    if q.size != g.size:
        return 1
    for at in range(0, g.size, 6):
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
        if not isfinite(total(g, at)):
            return 1
    return 0


@kernel(R1, R1, R1, R1, W1, hot=True)
def inverse(q, qd, qdd, k, tau):
    """Joint torque of every state of motion."""
    if q.size != tau.size or qd.size != tau.size or qdd.size != tau.size:
        return 1
    for at in range(0, tau.size, 6):
        turns, origins, lines = axes(q, at, k)
        t1, t2, t3, t4, t5, t6 = torque_of_motion(
            bodies(turns, origins, k), lines, qd, qdd, at, gravity_in_plane(q[at], k), k)
        tau[at] = t1 + k[ARMATURE] * qdd[at]
        tau[at + 1] = t2 + k[ARMATURE + 1] * qdd[at + 1]
        tau[at + 2] = t3 + k[ARMATURE + 2] * qdd[at + 2]
        tau[at + 3] = t4 + k[ARMATURE + 3] * qdd[at + 3]
        tau[at + 4] = t5 + k[ARMATURE + 4] * qdd[at + 4]
        tau[at + 5] = t6 + k[ARMATURE + 5] * qdd[at + 5]
        if not isfinite(total(tau, at)):
            return 1
    return 0
