"""Free bodies in the compiled step: their layout, their inertia, their motion."""

from math import cos, fabs, sin, sqrt

from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.model.kernels.plane_geometry import cross

#: Columns of a free body: mass, principal moments, place, quaternion (x, y, z, w), velocities.
MASS, MOMENTS, POSITION, QUATERNION, VELOCITY, SPIN = 0, 1, 4, 7, 11, 14
BODY = 17

#: A free body further away or faster than this has flown away [m], [m/s], [rad/s].
ESCAPE_DISTANCE, ESCAPE_SPEED = 100.0, 1000.0


@inlined
def write_rotation(body, R):
    """Write the rotation matrix of a body's quaternion."""
    x, y, z, w = (body[QUATERNION], body[QUATERNION + 1], body[QUATERNION + 2],
                  body[QUATERNION + 3])
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)


@inlined
def times_moments(R, body, v, inverse):
    """Return I v or I^-1 v, I = R diag(moments) R^T."""
    out = (0.0, 0.0, 0.0)
    for i in range(3):
        along = R[0, i] * v[0] + R[1, i] * v[1] + R[2, i] * v[2]
        along = along / body[MOMENTS + i] if inverse else along * body[MOMENTS + i]
        out = (out[0] + along * R[0, i], out[1] + along * R[1, i], out[2] + along * R[2, i])
    return out


@inlined
def write_free_velocity(body, R, gravity, h, u):
    """Write the velocity of a body that nothing touches, one step later: six numbers."""
    w = (body[SPIN], body[SPIN + 1], body[SPIN + 2])
    change = times_moments(R, body, cross(times_moments(R, body, w, False), w), True)
    for a in range(3):
        u[a] = body[VELOCITY + a] + h * gravity[a]
        u[3 + a] = body[SPIN + a] + h * change[a]


@inlined
def move_body(body, u, h):
    """Take the step of a body: velocity, place, turn; return whether it is possible."""
    for a in range(6):
        body[VELOCITY + a] = u[a]
    for a in range(3):
        body[POSITION + a] += h * body[VELOCITY + a]
    wx, wy, wz = h * body[SPIN], h * body[SPIN + 1], h * body[SPIN + 2]
    angle = sqrt(wx * wx + wy * wy + wz * wz)
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else sin(0.5 * angle) / angle
    c = cos(0.5 * angle)
    wx, wy, wz = s * wx, s * wy, s * wz
    x, y, z, w = (body[QUATERNION], body[QUATERNION + 1], body[QUATERNION + 2],
                  body[QUATERNION + 3])
    x, y, z, w = (c * x + wx * w + wy * z - wz * y, c * y - wx * z + wy * w + wz * x,
                  c * z + wx * y - wy * x + wz * w, c * w - wx * x - wy * y - wz * z)
    size = sqrt(x * x + y * y + z * z + w * w)
    body[QUATERNION], body[QUATERNION + 1] = x / size, y / size
    body[QUATERNION + 2], body[QUATERNION + 3] = z / size, w / size
    there = True
    for a in range(3):  # a comparison with NaN is false
        there &= (fabs(body[POSITION + a]) < ESCAPE_DISTANCE
                  and fabs(body[VELOCITY + a]) < ESCAPE_SPEED
                  and fabs(body[SPIN + a]) < ESCAPE_SPEED)
    return there
