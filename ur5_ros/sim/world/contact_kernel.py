"""
One physics step with contact, compiled: joints, free bodies and contact forces together.

The joints are solved exactly, with friction and stops, under the present contact forces; the
contacts are solved with the joints that stick or stand at a stop held; and so on until no joint
changes between held and free.  The joints come last, so that their equation holds to rounding
whatever the contacts have come to.
"""


from ur5_ros.model.kernels.base_parameters import D1, GRAVITY, SIZE
from ur5_ros.model.kernels.compiled import R1, R2, W1, W2, inlined, kernel
from ur5_ros.model.kernels.plane_geometry import axes
from ur5_ros.model.kernels.trigonometry import sine_cosine
from ur5_ros.sim.integrator_kernel import (
    FAILED,
    FREE,
    HELD,
    LOWER,
    STEP_TIME,
    STOP_TOLERANCE,
    UPPER,
    factor,
    prepare_step,
    solve_active_set,
    substitute,
)
from ur5_ros.sim.world.contact_rows import (
    write_body_responses,
    write_bounds,
    write_own_responses,
    write_rows,
)
from ur5_ros.sim.world.contact_solver import solve_contacts, write_first_guess
from ur5_ros.sim.world.free_bodies import VELOCITY, move_body, write_free_velocity, write_rotation

#: What :func:`contact_step` comes to besides HELD and FAILED.
ESCAPED = 3

#: Times that the joints are solved again, at most.
_PASSES = 8
#: Where the space of :func:`contact_step` has the state, the output (q', qd', joint torque of all
#: contacts, joints held, contacts with a force) and the rest.
OUT, OUTPUT = 66, 25
_WORK, _JOINTS = OUT + OUTPUT, 180
#: Where the constants have the joints' part, behind the packed arm and its angle offsets.
JOINT_CONSTANTS = SIZE + 6


def space(bodies: int, contacts: int) -> int:
    """Return the length of the space of :func:`contact_step`."""
    n = 6 + 6 * bodies
    return _WORK + _JOINTS + 2 * n + 9 * bodies + contacts * (6 * n + 20)


@inlined
def divide(work, bodies, contacts):
    """Return the parts of the working space behind that of the joints."""
    n, rows, at = 6 + 6 * bodies, 3 * contacts, _JOINTS
    u, before = work[at:at + n], work[at + n:at + 2 * n]
    at += 2 * n
    rotations = work[at:at + 9 * bodies].reshape((bodies, 3, 3))
    at += 9 * bodies
    J = work[at:at + rows * n].reshape((rows, n))
    at += rows * n
    X = work[at:at + rows * n].reshape((rows, n))
    at += rows * n
    F, limit = work[at:at + rows], work[at + rows:at + rows + contacts]
    give = work[at + rows + contacts:at + rows + 2 * contacts]
    at += rows + 2 * contacts
    directions = work[at:at + 9 * contacts].reshape((contacts, 3, 3))
    W = work[at + 9 * contacts:at + 15 * contacts].reshape((contacts, 6))
    return u, before, rotations, J, X, F, limit, give, directions, W


@inlined
def plane_of(q, k, angles):
    """Return the axes of the joints in the plane of the arm, and where that plane stands."""
    for j in range(6):
        angles[j] = q[j] + k[SIZE + j]
    _, _, lines = axes(angles, 0, k)
    s1, c1 = sine_cosine(angles[0])
    return lines, s1, c1, k[D1]


@inlined
def write_bodies(bodies, rotations, gravity, h, X, F, u):
    """Write the bodies' velocities after the step under the present contact forces."""
    for i in range(bodies.shape[0]):
        at = 6 + 6 * i
        write_free_velocity(bodies[i], rotations[i], gravity, h, u[at:at + 6])
        for r in range(F.shape[0]):
            for a in range(6):
                u[at + a] += X[r, at + a] * F[r]


@inlined
def write_joints(q, qd, delta, constants, J, F, out):
    """Write q', qd', the torque of all contacts and the joints held; return HELD if one is."""
    code, h = 0, constants[STEP_TIME]
    for j in range(6):
        out[6 + j] = qd[j] + delta[j]
        out[j] = q[j] + h * out[6 + j]
        out[18 + j] = 0.0
        if (out[j] >= constants[UPPER + j] - STOP_TOLERANCE
                or out[j] <= constants[LOWER + j] + STOP_TOLERANCE):
            out[18 + j], code = 1.0, HELD
        out[12 + j] = 0.0
        for r in range(F.shape[0]):
            out[12 + j] += J[r, j] * F[r]
    return code


@inlined
def write_forces(directions, F, force):
    """Write the force on A of every contact in base; return how many have one."""
    acting = 0
    for c in range(force.shape[0]):
        for a in range(3):
            force[c, a] = 0.0
            for r in range(3):
                force[c, a] += directions[c, r, a] * F[3 * c + r]
        if force[c, 0] != 0.0 or force[c, 1] != 0.0 or force[c, 2] != 0.0:
            acting += 1
    return acting


@kernel(W1, R1, W2, R2, R2, R2, W2, hot=True)
def contact_step(room, k, bodies, points, last_points, last_force, force):
    """
    Take one step of arm and bodies; return 0, HELD, FAILED or ESCAPED.

    ``room`` begins with the state as of ``engine_torque`` and gets the output; ``k`` is the packed
    arm in the gravity in force, its angle offsets, and the constants of ``engine_torque``;
    ``force`` becomes the force on A of every contact in ``base``.
    """
    state, out, work = room[:OUT], room[OUT:_WORK], room[_WORK:]
    constants = k[JOINT_CONSTANTS:]
    q, qd, gravity, h = state[42:48], state[48:54], k[GRAVITY:GRAVITY + 3], constants[STEP_TIME]
    M, drive = work[:36].reshape((6, 6)), work[36:42]
    lowest, highest, delta, f = work[42:48], work[48:54], work[54:60], work[60:66]
    solving, loaded = work[66:132].reshape((11, 6)), work[132:138]
    L, level, was_free = work[138:174].reshape((6, 6)), work[174:180], out[6:12]
    free = solving[FREE]
    count, number, rows = points.shape[0], bodies.shape[0], 3 * points.shape[0]
    u, before, rotations, J, X, F, limit, give, directions, W = divide(work, number, count)
    prepare_step(state, constants, M, drive, lowest, highest, level)
    for j in range(6):
        before[j] = qd[j]
    for i in range(number):
        write_rotation(bodies[i], rotations[i])
        for a in range(6):
            before[6 + 6 * i + a] = bodies[i, VELOCITY + a]
    if count:
        write_rows(points, bodies, plane_of(q, k, out[:6]), J, directions)
        write_bounds(points, J, before, h, limit, give)
        write_first_guess(points, last_points, last_force, directions, F)
        write_body_responses(J, X, bodies, rotations, h)
    for attempt in range(_PASSES + 1):
        for j in range(6):
            loaded[j] = drive[j]
            for r in range(rows):
                loaded[j] += J[r, j] * F[r]
        if solve_active_set(M, loaded, qd, level, lowest, highest, solving, delta, f):
            return FAILED
        same = attempt > 0
        for j in range(6):
            same &= was_free[j] == free[j]
        if same or not count or attempt == _PASSES:
            break
        for j in range(6):
            was_free[j], u[j] = free[j], qd[j] + delta[j]
        factor(M, free, L)
        for r in range(rows):
            for j in range(6):
                X[r, j] = 0.0
            substitute(L, free, J[r], X[r])
        write_own_responses(J, X, W)
        write_bodies(bodies, rotations, gravity, h, X, F, u)
        solve_contacts(points, J, X, W, limit, give, u, F)
    code = write_joints(q, qd, delta, constants, J, F, out)
    write_bodies(bodies, rotations, gravity, h, X, F, u)
    for i in range(number):
        if not move_body(bodies[i], u[6 + 6 * i:12 + 6 * i], h):
            code = ESCAPED
    out[24] = write_forces(directions, F, force)
    return code
