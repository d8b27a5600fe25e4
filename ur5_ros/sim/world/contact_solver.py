"""
Forces of all contacts at the velocity after the step: projected Gauss-Seidel, contact by contact.

The normal force only presses and acts only where the bodies would come too close; friction
opposes the slip and is at most its coefficient times the normal force, in every direction alike.
"""

from math import fabs, sqrt

from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.sim.world.contact_rows import FRICTION, PLACE, A, B, dot

#: Sweeps over all contacts, and rounds for one contact in a sweep, at most.
SWEEPS, _ROUNDS = 500, 50
#: Change of a contact's velocity below which it is solved [m/s].
_TOLERANCE = 1e-12
#: Response below which a force moves nothing [m/(s N)].
_RIGID = 1e-14
#: A contact this near to one of the step before begins with its force [m^2].
_SAME_PLACE = 4e-6


@inlined
def solve_contact(w, v, F, n, coefficient, limit, give):
    """
    Solve one contact, whose rows begin at n, with all others as they are; return the change of F.

    ``w`` holds what a unit of its force adds to its velocity ``v``: 00, 11, 22, 01, 02, 12.
    """
    f0, f1, f2 = F[n], F[n + 1], F[n + 2]
    x0, x1, x2 = f0, f1, f2
    v0, v1, v2 = v
    w00, w11, w22, w01, w02, w12 = w
    det, step = w11 * w22 - w12 * w12, max(w11, w22) + fabs(w12)
    for _ in range(_ROUNDS):
        d0 = 0.0
        if w00 + give > _RIGID:
            d0 = max(-(v0 + give * x0 - limit) / (w00 + give), -x0)
        x0, v0, v1, v2 = x0 + d0, v0 + w00 * d0, v1 + w01 * d0, v2 + w02 * d0
        most, y1, y2, sticks = coefficient * x0, x1, x2, False
        if det > 1e-12 * w11 * w22:
            y1, y2 = x1 - (w22 * v1 - w12 * v2) / det, x2 - (w11 * v2 - w12 * v1) / det
            sticks = y1 * y1 + y2 * y2 <= most * most
        if not sticks:
            y1, y2 = x1, x2
            if step > _RIGID:
                y1, y2 = x1 - v1 / step, x2 - v2 / step
            size = sqrt(y1 * y1 + y2 * y2)
            if size > most:
                y1, y2 = y1 * most / size, y2 * most / size
        d1, d2 = y1 - x1, y2 - x2
        x1, x2 = y1, y2
        v0, v1, v2 = v0 + w01 * d1 + w02 * d2, v1 + w11 * d1 + w12 * d2, v2 + w12 * d1 + w22 * d2
        if max(fabs(d0) * w00, fabs(d1) * w11, fabs(d2) * w22) <= _TOLERANCE:
            break
    F[n], F[n + 1], F[n + 2] = x0, x1, x2
    return x0 - f0, x1 - f1, x2 - f2


@inlined
def add_response(u, X, row, change):
    """Change the velocities as a change of one row's force does."""
    for i in range(u.shape[0]):
        u[i] += X[row, i] * change


@inlined
def solve_contacts(points, J, X, W, limit, give, u, F):
    """Write forces F and velocities u that all contacts agree with; return the sweeps it took."""
    for sweep in range(SWEEPS):
        worst = 0.0
        for c in range(points.shape[0]):
            n = 3 * c
            w = (W[c, 0], W[c, 1], W[c, 2], W[c, 3], W[c, 4], W[c, 5])
            v = (dot(J[n], u), dot(J[n + 1], u), dot(J[n + 2], u))
            d0, d1, d2 = solve_contact(w, v, F, n, points[c, FRICTION], limit[c], give[c])
            add_response(u, X, n, d0)
            add_response(u, X, n + 1, d1)
            add_response(u, X, n + 2, d2)
            worst = max(worst, fabs(d0) * w[0], fabs(d1) * w[1], fabs(d2) * w[2])
        if worst <= _TOLERANCE:
            return sweep + 1
    return SWEEPS


@inlined
def write_first_guess(points, last_points, last_force, directions, F):
    """Write the force that acted at the same place in the step before; zero where none did."""
    for c in range(points.shape[0]):
        near, found = _SAME_PLACE, -1
        for o in range(last_points.shape[0]):
            if last_points[o, A] == points[c, A] and last_points[o, B] == points[c, B]:
                d = 0.0
                for a in range(3):
                    d += (last_points[o, PLACE + a] - points[c, PLACE + a])**2
                if d < near:
                    near, found = d, o
        for r in range(3):
            F[3 * c + r] = 0.0
            if found >= 0:
                for a in range(3):
                    F[3 * c + r] += directions[c, r, a] * last_force[found, a]
        F[3 * c] = max(F[3 * c], 0.0)
