"""
The arm seen from its own plane: axes, bodies and motions as the dynamics kernels need them.

All vectors stand in frame 1 (x outwards, y up, z the common direction of axes 2, 3 and 4) and
all moments are about its origin, through which axes 1 and 2 pass: whatever joint 1 does, that
point rests.  An axis is (w, u): the point x of a body that turns about it at unit speed moves at
w x x + u.
"""

from ur5_ros.model.kernels.base_parameters import A2, A3, BODY, D4, D5, GRAVITY
from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.model.kernels.trigonometry import sine_cosine


@inlined
def cross(a, b):
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def dot(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def add(a, b):
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def add_scaled(a, s, b):
    """Return a + s b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


@inlined
def total(x, at):
    """Return the sum of six numbers: not finite where one of them is not."""
    return (x[at] + x[at + 1] + x[at + 2] + x[at + 3] + x[at + 4]
            + x[at + 5])


@inlined
def axes(q, at, k):
    """
    Return sines and cosines, axis origins, and (u3, u4, w5, u5, w6, u6) of the axes 3 to 6.

    Axis 2 is ((0, 0, 1), (0, 0, 0)) and the axes 3, 4 have the same direction.  The six numbers
    of a state begin at index ``at``, here and in all functions that take it.
    """
    q2, q5, q6 = q[at + 1], q[at + 4], q[at + 5]
    q23 = q2 + q[at + 2]
    q234 = q23 + q[at + 3]
    s2, c2 = sine_cosine(q2)
    s23, c23 = sine_cosine(q23)
    s234, c234 = sine_cosine(q234)
    s5, c5 = sine_cosine(q5)
    s6, c6 = sine_cosine(q6)
    o2 = (k[A2] * c2, k[A2] * s2, 0.0)
    o3 = (o2[0] + k[A3] * c23, o2[1] + k[A3] * s23, 0.0)
    o4 = (o3[0], o3[1], k[D4])
    w5 = (s234, -c234, 0.0)
    o5 = add_scaled(o4, k[D5], w5)
    w6 = (-s5 * c234, -s5 * s234, c5)
    u3 = (o2[1], -o2[0], 0.0)
    u4 = (o3[1], -o3[0], 0.0)
    turns = (c2, s2, c23, s23, c234, s234, c5, s5, c6, s6)
    return turns, (o2, o3, o4, o5), (u3, u4, w5, cross(o4, w5), w6, cross(o5, w6))


@inlined
def turned(h, e, c, s):
    """Return first moments (x, y, z) and second (xx, xy, yy, xz, yz, zz) turned about z."""
    xx, xy, yy, xz, yz, zz = e
    ax, ay, bx, by = c * xx - s * xy, c * xy - s * yy, s * xx + c * xy, s * xy + c * yy
    return ((c * h[0] - s * h[1], s * h[0] + c * h[1], h[2]),
            (c * ax - s * ay, s * ax + c * ay, s * bx + c * by, c * xz - s * yz, s * xz + c * yz,
             zz))


@inlined
def tilted(h, e, s):
    """Return the moments turned about x by a right angle, positive (s = 1) or negative (-1)."""
    xx, xy, yy, xz, yz, zz = e
    return (h[0], -s * h[2], s * h[1]), (xx, -s * xz, zz, s * xy, -yz, yy)


@inlined
def shifted(h, e, r):
    """Return the second moments of a body without mass about a point that lies at -r."""
    xx, xy, yy, xz, yz, zz = e
    return (xx + 2.0 * h[0] * r[0], xy + h[0] * r[1] + h[1] * r[0], yy + 2.0 * h[1] * r[1],
            xz + h[0] * r[2] + h[2] * r[0], yz + h[1] * r[2] + h[2] * r[1],
            zz + 2.0 * h[2] * r[2])


@inlined
def body(k, i):
    """Return first and second moments of link i (2 to 6) in the frame that turns with it."""
    at = BODY + 7 * (i - 2)
    return ((k[at], k[at + 1], 0.0), (k[at + 2], k[at + 3], k[at + 4], k[at + 5], k[at + 6], 0.0))


@inlined
def bodies(turns, origins, k):
    """Return (first moments, second moments) of links 2 to 6 in frame 1, about its origin."""
    c2, s2, c23, s23, c234, s234, c5, s5, c6, s6 = turns
    o2, o3, o4, o5 = origins
    h2, e2 = body(k, 2)
    h2, e2 = turned(h2, e2, c2, s2)
    h3, e3 = body(k, 3)
    h3, e3 = turned(h3, e3, c23, s23)
    e3 = shifted(h3, e3, o2)
    h4, e4 = body(k, 4)
    h4, e4 = turned(h4, e4, c234, s234)
    e4 = shifted(h4, e4, o3)
    h5, e5 = body(k, 5)
    h5, e5 = turned(h5, e5, c5, s5)
    h5, e5 = tilted(h5, e5, 1.0)
    h5, e5 = turned(h5, e5, c234, s234)
    e5 = shifted(h5, e5, o4)
    h6, e6 = body(k, 6)
    h6, e6 = turned(h6, e6, c6, s6)
    h6, e6 = tilted(h6, e6, -1.0)
    h6, e6 = turned(h6, e6, c5, s5)
    h6, e6 = tilted(h6, e6, 1.0)
    h6, e6 = turned(h6, e6, c234, s234)
    e6 = shifted(h6, e6, o5)
    return (h2, e2), (h3, e3), (h4, e4), (h5, e5), (h6, e6)


@inlined
def gravity_in_plane(q1, k):
    """Return the gravitational acceleration in frame 1."""
    s1, c1 = sine_cosine(q1)
    gx, gy, gz = k[GRAVITY], k[GRAVITY + 1], k[GRAVITY + 2]
    return (c1 * gx + s1 * gy, gz, s1 * gx - c1 * gy)
