"""Contacts in the compiled step: their Jacobian, what a force on them does, what they allow."""

from math import fabs, sqrt

from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.model.kernels.composite_inertia import column
from ur5_ros.model.kernels.plane_geometry import cross
from ur5_ros.sim.world.free_bodies import MASS, POSITION, times_moments

#: Columns of a contact point: bodies A and B, place, normal (on B, towards A), gap, and the pair's
#: friction, restitution, stiffness and damping.
A, B, PLACE, NORMAL, GAP, FRICTION, RESTITUTION, STIFFNESS, DAMPING = 0, 1, 2, 5, 8, 9, 10, 11, 12
POINT = 13
#: The first six body indices are the links of the arm; -1 is what does not move.
FIRST_BODY = 6

#: Depth at which a rigid contact rests, so that PyBullet goes on to report it [m].
REST_DEPTH = 1e-7
#: Share of a deeper penetration that is undone in a step, and the speed at which this is done at
#: most [m/s].
RECOVERY, RECOVERY_SPEED = 0.1, 0.05
#: Below this closing speed nothing bounces [m/s].
BOUNCE_SPEED = 0.01


@inlined
def dot(a, b):
    """Return a . b."""
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


@inlined
def tangents(n):
    """Return two unit vectors across a unit vector and each other."""
    if fabs(n[0]) < 0.6:
        t = (0.0, -n[2], n[1])
    else:
        t = (n[2], 0.0, -n[0])
    size = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    t = (t[0] / size, t[1] / size, t[2] / size)
    return t, cross(n, t)


@inlined
def add_row(row, sign, index, place, direction, bodies, plane):
    """Add to a row of J what a unit force on one body, at a place along a direction, does."""
    if index >= FIRST_BODY:
        i = index - FIRST_BODY
        lever = (place[0] - bodies[i, POSITION], place[1] - bodies[i, POSITION + 1],
                 place[2] - bodies[i, POSITION + 2])
        moment = cross(lever, direction)
        for a in range(3):
            row[6 + 6 * i + a] += sign * direction[a]
            row[9 + 6 * i + a] += sign * moment[a]
    elif index >= 0:
        lines, s1, c1, d1 = plane
        f = (c1 * direction[0] + s1 * direction[1], direction[2],
             s1 * direction[0] - c1 * direction[1])
        x = (c1 * place[0] + s1 * place[1], place[2] - d1, s1 * place[0] - c1 * place[1])
        t = column(f, cross(x, f), lines)
        for j in range(6):
            if j <= index:
                row[j] += sign * t[j]


@inlined
def write_rows(points, bodies, plane, J, directions):
    """Write normal and tangents of every contact, and their rows of J."""
    for c in range(points.shape[0]):
        normal = (points[c, NORMAL], points[c, NORMAL + 1], points[c, NORMAL + 2])
        place = (points[c, PLACE], points[c, PLACE + 1], points[c, PLACE + 2])
        t1, t2 = tangents(normal)
        for r in range(3):
            d = normal if r == 0 else (t1 if r == 1 else t2)
            row = J[3 * c + r]
            for a in range(3):
                directions[c, r, a] = d[a]
            for j in range(row.shape[0]):
                row[j] = 0.0
            add_row(row, 1.0, int(points[c, A]), place, d, bodies, plane)
            add_row(row, -1.0, int(points[c, B]), place, d, bodies, plane)


@inlined
def write_bounds(points, J, before, h, limit, give):
    """
    Write the least normal speed of every contact and its compliance.

    Allowed is v_n + give F >= limit, with F = 0 where it is more.  A spring and damper taken at
    the end of the step is F = -k (gap + h v_n) - d v_n.
    """
    for c in range(points.shape[0]):
        gap = points[c, GAP]
        if points[c, STIFFNESS] > 0.0:
            give[c] = 1.0 / (h * points[c, STIFFNESS] + points[c, DAMPING])
            limit[c] = -points[c, STIFFNESS] * gap * give[c]
            continue
        room, speed = gap + REST_DEPTH, dot(J[3 * c], before)
        give[c] = 0.0
        limit[c] = -room / h if room > 0.0 else min(-RECOVERY * room / h, RECOVERY_SPEED)
        if points[c, RESTITUTION] > 0.0 and speed < -BOUNCE_SPEED and room + h * speed <= 0.0:
            limit[c] = max(limit[c], -points[c, RESTITUTION] * speed)


@inlined
def write_body_responses(J, X, bodies, rotations, h):
    """Write the change of the bodies' velocities for a unit force along each row."""
    for r in range(J.shape[0]):
        for i in range(bodies.shape[0]):
            at, share = 6 + 6 * i, h / bodies[i, MASS]
            moment = times_moments(rotations[i], bodies[i],
                                   (J[r, at + 3], J[r, at + 4], J[r, at + 5]), True)
            for a in range(3):
                X[r, at + a] = share * J[r, at + a]
                X[r, at + 3 + a] = h * moment[a]


@inlined
def write_own_responses(J, X, W):
    """Write what each contact's own force does to its own velocity: 00, 11, 22, 01, 02, 12."""
    for c in range(W.shape[0]):
        n = 3 * c
        W[c, 0], W[c, 1] = dot(J[n], X[n]), dot(J[n + 1], X[n + 1])
        W[c, 2], W[c, 3] = dot(J[n + 2], X[n + 2]), dot(J[n], X[n + 1])
        W[c, 4], W[c, 5] = dot(J[n], X[n + 2]), dot(J[n + 1], X[n + 2])
