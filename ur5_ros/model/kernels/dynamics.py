"""
Kernels of the dynamics: M, C, g from composite moments, torque and acceleration from one pass.

A kernel takes states one after the other; for many states there is a second form that copies
eight at a time side by side, where the processor works on all eight at once.
"""

from math import isfinite

import numpy as np
from numpy import intp

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
from ur5_ros.model.kernels.lanes import LANES, gather, put, scatter, store_simd
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
def write_column(out, at, step, j, entries, write):
    """Write the entries 1 to j + 1 of column j."""
    write(out, at, step, intp(0), j, entries[0])
    write(out, at, step, intp(1), j, entries[1])
    if j > 1:
        write(out, at, step, intp(2), j, entries[2])
    if j > 2:
        write(out, at, step, intp(3), j, entries[3])
    if j > 3:
        write(out, at, step, intp(4), j, entries[4])
    if j > 4:
        write(out, at, step, intp(5), j, entries[5])


@inlined
def write_row(out, at, step, i, entries, write):
    """Write the entries 1 to i of row i, left of the diagonal."""
    write(out, at, step, i, intp(0), entries[0])
    if i > 1:
        write(out, at, step, i, intp(1), entries[1])
    if i > 2:
        write(out, at, step, i, intp(2), entries[2])
    if i > 3:
        write(out, at, step, i, intp(3), entries[3])
    if i > 4:
        write(out, at, step, i, intp(4), entries[4])


@inlined
def write_mass(m, at, step, j, entries, k, write):
    """Write column and row j of M, the rotor on the diagonal."""
    write_column(m, at, step, j, entries, write)
    write_row(m, at, step, j, entries, write)
    write(m, at, step, j, j, entries[j] + k[ARMATURE + j])


@inlined
def joint(at, step, j, composite, axis, axis_rate, lines, line_rates, a, k, m, c, g, write):
    """Write what the composite of links j + 1 to 6 adds: M, C and g with j the larger index."""
    h, e, p, d = composite
    w, u = axis
    wd2, ud3, ud4, wd5, ud5 = line_rates
    f, n = momentum(h, e, w, u)
    g[at + j * step] = -dot(a, f)
    write_mass(m, at, step, j, column(f, n, lines), k, write)
    mf, mn = coriolis_force(h, e, p, d, axis, axis_rate)
    write_column(c, at, step, j, column(mf, mn, lines), write)
    r = coriolis_row(p, d, w, u)
    turn = n[0] * wd2 + r[2]  # axes 2, 3 and 4 turn alike
    write_row(c, at, step, j, (r[1], turn, turn + dot(f, ud3), turn + dot(f, ud4),
                               dot(n, wd5) + dot(f, ud5) + dot(r, lines[2])), write)


@inlined
def terms_of_state(q, qd, k, m, c, g, at, step, write):
    """Write M, C and g of one state; return a number that is finite if all went well."""
    turns, origins, lines = axes(q, at, step, k)
    u3, u4, w5, u5, w6, u6 = lines
    b2, b3, b4, b5, b6 = bodies(turns, origins, k)
    s2, s3, s4, s5, s6 = velocities(qd, at, step, lines)
    r3, r4, r5, r6 = rates(s3, Z, u3), rates(s4, Z, u4), rates(s5, w5, u5), rates(s6, w6, u6)
    moved = qd[at], r3[1], r4[1], r5[0], r5[1]
    a = gravity_in_plane(q[at], k)
    whole = flow(b6, s6)
    joint(at, step, intp(5), whole, (w6, u6), r6, lines, moved, a, k, m, c, g, write)
    whole = joined(whole, flow(b5, s5))
    joint(at, step, intp(4), whole, (w5, u5), r5, lines, moved, a, k, m, c, g, write)
    whole = joined(whole, flow(b4, s4))
    joint(at, step, intp(3), whole, (Z, u4), r4, lines, moved, a, k, m, c, g, write)
    whole = joined(whole, flow(b3, s3))
    joint(at, step, intp(2), whole, (Z, u3), r3, lines, moved, a, k, m, c, g, write)
    whole = joined(whole, flow(b2, s2))
    r2 = ((qd[at], 0.0, 0.0), NIL)
    joint(at, step, intp(1), whole, (Z, NIL), r2, lines, moved, a, k, m, c, g, write)
    h, e, p, d = whole
    write(m, at, step, intp(0), intp(0), e[0] + e[5] + k[SPIN] + k[ARMATURE])
    write(c, at, step, intp(0), intp(0), d[0] + d[8])
    g[at] = a[2] * (h[0] + k[SHOULDER + 1]) - a[0] * (h[2] + k[SHOULDER + 3])
    return total(qd, at, step) + total(g, at, step) + d[0] + d[4] + d[8] + dot(p, p)


@kernel(R1, R1, R1, W2, W2, W1)
def terms(q, qd, k, m, c, g):
    """M, C and g of every state."""
    if q.size != g.size or qd.size != g.size:
        return 1
    for at in range(0, g.size, 6):
        if not isfinite(terms_of_state(q, qd, k, m, c, g, at, intp(1), put)):
            return 1
    return 0


@terms.side_by_side
def terms_of_many(q, qd, k, m, c, g):
    """M, C and g of every state, eight at a time."""
    work = np.empty(91 * LANES)
    lq, lqd, lm = work[:6 * LANES], work[6 * LANES:12 * LANES], work[12 * LANES:48 * LANES]
    lc, lg, check = work[48 * LANES:84 * LANES], work[84 * LANES:90 * LANES], work[90 * LANES:]
    count = g.size // 6
    flat_m, flat_c = m.reshape(m.size), c.reshape(c.size)
    for first in range(0, count, LANES):
        some = min(LANES, count - first)
        gather(q, first, some, lq)
        gather(qd, first, some, lqd)
        for lane in range(LANES):
            check[lane] = terms_of_state(lq, lqd, k, lm, lc, lg, lane, intp(LANES), store_simd)
        if not isfinite(np.sum(check)):
            return 1
        scatter(lm, 36, first, some, flat_m)
        scatter(lc, 36, first, some, flat_c)
        scatter(lg, 6, first, some, g)
    return 0


@inlined
def mass_columns(bodies_in_plane, lines, k):
    """Return the columns of M of one state, each down to the diagonal, and M11."""
    (h2, e2), (h3, e3), (h4, e4), (h5, e5), (h6, e6) = bodies_in_plane
    u3, u4, w5, u5, w6, u6 = lines
    f, n = momentum(h6, e6, w6, u6)
    c6 = column(f, n, lines)
    h, e = add(h5, h6), six(e5, e6)
    f, n = momentum(h, e, w5, u5)
    c5 = column(f, n, lines)
    h, e = add(h, h4), six(e, e4)
    f, n = momentum(h, e, Z, u4)
    c4 = column(f, n, lines)
    h, e = add(h, h3), six(e, e3)
    f, n = momentum(h, e, Z, u3)
    c3 = column(f, n, lines)
    h, e = add(h, h2), six(e, e2)
    f, n = momentum(h, e, Z, NIL)
    return e[0] + e[5] + k[SPIN] + k[ARMATURE], column(f, n, lines), c3, c4, c5, c6


@kernel(R1, R1, W2)
def inertia(q, k, m):
    """M of every state."""
    if m.shape[0] != q.size:
        return 1
    for at in range(0, q.size, 6):
        turns, origins, lines = axes(q, at, 1, k)
        m11, c2, c3, c4, c5, c6 = mass_columns(bodies(turns, origins, k), lines, k)
        m[at, 0] = m11
        write_mass(m, at, intp(1), intp(1), c2, k, put)
        write_mass(m, at, intp(1), intp(2), c3, k, put)
        write_mass(m, at, intp(1), intp(3), c4, k, put)
        write_mass(m, at, intp(1), intp(4), c5, k, put)
        write_mass(m, at, intp(1), intp(5), c6, k, put)
        if not isfinite(q[at] + m11 + c5[4] + c6[5] + c6[0]):
            return 1
    return 0


@kernel(R1, R1, W1)
def gravity(q, k, g):
    """Holding torque of every state."""
    if q.size != g.size:
        return 1
    for at in range(0, g.size, 6):
        turns, origins, lines = axes(q, at, 1, k)
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
        if not isfinite(total(g, at, 1)):
            return 1
    return 0


@inlined
def torque_of_state(q, qd, qdd, k, tau, at, step):
    """Write the joint torque of one state of motion; return its sum."""
    turns, origins, lines = axes(q, at, step, k)
    t1, t2, t3, t4, t5, t6 = torque_of_motion(
        bodies(turns, origins, k), lines, qd, qdd, at, step, gravity_in_plane(q[at], k), k)
    tau[at] = t1 + k[ARMATURE] * qdd[at]
    tau[at + step] = t2 + k[ARMATURE + 1] * qdd[at + step]
    tau[at + 2 * step] = t3 + k[ARMATURE + 2] * qdd[at + 2 * step]
    tau[at + 3 * step] = t4 + k[ARMATURE + 3] * qdd[at + 3 * step]
    tau[at + 4 * step] = t5 + k[ARMATURE + 4] * qdd[at + 4 * step]
    tau[at + 5 * step] = t6 + k[ARMATURE + 5] * qdd[at + 5 * step]
    return total(tau, at, step)


@kernel(R1, R1, R1, R1, W1)
def inverse(q, qd, qdd, k, tau):
    """Joint torque of every state of motion."""
    if q.size != tau.size or qd.size != tau.size or qdd.size != tau.size:
        return 1
    for at in range(0, tau.size, 6):
        if not isfinite(torque_of_state(q, qd, qdd, k, tau, at, 1)):
            return 1
    return 0


@inverse.side_by_side
def torque_of_many(q, qd, qdd, k, tau):
    """Joint torque of every state of motion, eight at a time."""
    work = np.empty(25 * LANES)
    lq, lqd, lqdd = work[:6 * LANES], work[6 * LANES:12 * LANES], work[12 * LANES:18 * LANES]
    ltau, check = work[18 * LANES:24 * LANES], work[24 * LANES:]
    count = tau.size // 6
    for first in range(0, count, LANES):
        some = min(LANES, count - first)
        gather(q, first, some, lq)
        gather(qd, first, some, lqd)
        gather(qdd, first, some, lqdd)
        for lane in range(LANES):
            check[lane] = torque_of_state(lq, lqd, lqdd, k, ltau, lane, LANES)
        if not isfinite(np.sum(check)):
            return 1
        scatter(ltau, 6, first, some, tau)
    return 0
