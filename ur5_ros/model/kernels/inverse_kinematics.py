"""
Kernels of the inverse kinematics: all branches of a pose.

Slots 0 to 7 are 4 shoulder + 2 elbow + wrist; the signs behind them are those of the three factors
of det J, so that a branch ends nowhere but at a singularity.
"""

from math import acos, copysign, isfinite, nan, pi, sqrt

from ur5_ros.model.kernels.base_parameters import A2, A3, D1, D4, D5, D6
from ur5_ros.model.kernels.compiled import B1, R1, R2, W2, inlined, kernel
from ur5_ros.model.kernels.trigonometry import arctangent, sine_cosine

#: What a matrix may lack of a rigid transform.
RIGID_TOLERANCE = 1e-6
#: How far outside the reach a pose is still taken as rounded [m].
REACH_TOLERANCE = 5e-10
#: Below this |sin q5| joint 6 is free [1].
STRAIGHT_WRIST = 1e-10
#: Elbow or shoulder branches nearer to each other than this are one [rad].
MERGE_DISTANCE = 1e-7
#: Below this sin q5 the reach also decides q6 [1].
ALMOST_STRAIGHT = 1e-5
#: So near to axis 1 the side may be chosen: the pose moves by its square [m].
ABOVE_AXIS = 5e-6

# Codes of a single pose: bits 0 to 7 are the slots with a solution, the others what is special.
SINGULAR, NOT_RIGID, BAD_SHAPE = 256, 512, 1024


@inlined
def wrapped(x):
    """Return an angle of (-3 pi, 3 pi) in (-pi, pi]."""
    if x > pi:
        return x - 2.0 * pi
    if x <= -pi:
        return x + 2.0 * pi
    return x


@inlined
def is_rigid(t, r):
    """Return whether the four rows from r on are a rigid transform."""
    xx, xy, xz = t[r, 0], t[r, 1], t[r, 2]
    yx, yy, yz = t[r + 1, 0], t[r + 1, 1], t[r + 1, 2]
    zx, zy, zz = t[r + 2, 0], t[r + 2, 1], t[r + 2, 2]
    defect = max(abs(xx * xx + xy * xy + xz * xz - 1.0), abs(yx * yx + yy * yy + yz * yz - 1.0),
                 abs(xy * yz - xz * yy - zx), abs(xz * yx - xx * yz - zy),
                 abs(xx * yy - xy * yx - zz), abs(xx * yx + xy * yy + xz * yz),
                 abs(t[r + 3, 0]), abs(t[r + 3, 1]), abs(t[r + 3, 2]), abs(t[r + 3, 3] - 1.0))
    return defect <= RIGID_TOLERANCE and isfinite(t[r, 3] + t[r + 1, 3] + t[r + 2, 3])


@inlined
def elbows(q, at, slot, q1, q5, q6, c6, s6, c5, s5, plane, k):
    """Fill the two elbow slots of one shoulder and wrist; return their bits."""
    nx, ny, ox, oy, ax, ay, px, py = plane  # n, o, a and the origin of frame 5: out, up
    a2, a3 = k[A2], k[A3]
    q234 = arctangent(c5 * (c6 * ny - s6 * oy) - s5 * ay, c5 * (c6 * nx - s6 * ox) - s5 * ax)
    x = px + k[D5] * (s6 * nx + c6 * ox)
    y = py + k[D5] * (s6 * ny + c6 * oy)
    r2 = x * x + y * y
    product = a2 * a3
    outer, inner = abs(a2) + abs(a3), abs(abs(a2) - abs(a3))
    far, near = outer * outer - r2, r2 - inner * inner
    if far < -2.0 * outer * REACH_TOLERANCE or near < -2.0 * inner * REACH_TOLERANCE:
        return 0
    if product < 0.0:
        far, near = near, far
    u, v = sqrt(max(far, 0.0)), sqrt(max(near, 0.0))
    q3 = 2.0 * arctangent(u, v)
    scale = u * u + v * v
    c3, s3 = (v * v - u * u) / scale, 2.0 * u * v / scale
    merged = min(q3, pi - q3) < 0.5 * MERGE_DISTANCE
    # elbow up: sin q3 has the sign of a2 a3 on the left, the opposite on the right
    up = 1.0 if (product > 0.0) == (slot < 4) else -1.0
    found = 0
    along, across = a2 + a3 * c3, a3 * s3
    for elbow in range(1 if merged else 2):
        sign = up if elbow == 0 else -up
        q2 = arctangent(y * along - sign * x * across, x * along + sign * y * across)
        i = slot + 2 * elbow
        row = at + i
        q[row, 0] = q1
        q[row, 1] = q2
        q[row, 2] = wrapped(sign * q3)
        q[row, 3] = wrapped(wrapped(q234 - q2) - sign * q3)
        q[row, 4] = q5
        q[row, 5] = q6
        found |= 1 << i
    return found


@inlined
def reachable(q6, plane, k):
    """Return the angle of joint 6 nearest to q6 whose wrist joints 2 and 3 can span."""
    nx, ny, ox, oy, ax, ay, px, py = plane
    inner, outer = abs(abs(k[A2]) - abs(k[A3])), abs(k[A2]) + abs(k[A3])
    pn, po = px * nx + py * ny, px * ox + py * oy
    base, swing = px * px + py * py + k[D5] * k[D5], 2.0 * k[D5] * sqrt(pn * pn + po * po)
    if abs(swing) < 1e-12:
        return q6
    peak = arctangent(pn, po)
    if swing < 0.0:
        peak, swing = peak + pi, -swing
    angle = wrapped(wrapped(q6 - peak))
    least = acos(max(-1.0, min(1.0, (outer * outer - base) / swing)))
    most = acos(max(-1.0, min(1.0, (inner * inner - base) / swing)))
    if least <= abs(angle) <= most:
        return q6
    return wrapped(peak + copysign(min(max(abs(angle), least), most), angle))


@inlined
def wrists(t, r, q6_free, k, q, at, shoulder, c1, s1, side):
    """Fill the four slots of one shoulder; return their bits."""
    n3, o3, a3 = t[r + 2, 0], t[r + 2, 1], t[r + 2, 2]
    yn, yo = c1 * t[r + 1, 0] - s1 * t[r, 0], c1 * t[r + 1, 1] - s1 * t[r, 1]
    ya = c1 * t[r + 1, 2] - s1 * t[r, 2]
    plane = (c1 * t[r, 0] + s1 * t[r + 1, 0], n3, c1 * t[r, 1] + s1 * t[r + 1, 1], o3,
             c1 * t[r, 2] + s1 * t[r + 1, 2], a3, side, t[r + 2, 3] - k[D6] * a3 - k[D1])
    q1 = arctangent(s1, c1)
    s5 = sqrt(yn * yn + yo * yo)
    if s5 <= STRAIGHT_WRIST:
        q6 = reachable(q6_free, plane, k)
        s6, c6 = sine_cosine(q6)
        c5, q5 = (1.0, 0.0) if ya < 0.0 else (-1.0, pi)
        return SINGULAR | elbows(q, at, 4 * shoulder, q1, q5, q6, c6, s6, c5, 0.0,
                                 plane, k)
    q5, q6 = arctangent(s5, -ya), arctangent(yo, -yn)
    c6, s6 = -yn / s5, yo / s5
    found = 0
    length = 1.0 / sqrt(s5 * s5 + ya * ya)
    c5, s5 = -ya * length, s5 * length
    for flipped in range(2):
        sign = 1.0 - 2.0 * flipped
        own, c, s = q6 if flipped == 0 else wrapped(q6 + pi), sign * c6, sign * s6
        if s5 < ALMOST_STRAIGHT:  # joint 6 is known as badly as joint 5 is small
            better = reachable(own, plane, k)
            if s5 * abs(wrapped(better - own)) < REACH_TOLERANCE:
                own = better
                s, c = sine_cosine(own)
        found |= elbows(q, at, 4 * shoulder + flipped, q1, sign * q5, own, c, s, c5, sign * s5,
                        plane, k)
    return found


@inlined
def branches(t, r, q6_free, k, q, at):
    """Fill the slots of q from row ``at`` on with the solutions of the pose from row r on."""
    px, py = t[r, 3] - k[D6] * t[r, 2], t[r + 1, 3] - k[D6] * t[r + 1, 2]
    d4 = k[D4]
    beyond = px * px + py * py - d4 * d4
    if beyond < -2.0 * abs(d4) * REACH_TOLERANCE:
        return 0
    rho = sqrt(max(beyond, 0.0))
    if rho < 0.5 * MERGE_DISTANCE * abs(d4):
        rho = 0.0
    found = 0
    for attempt in range(2):
        scale = 1.0 / (rho * rho + d4 * d4)
        # the origin of frame 5 lies at x = -rho (left) or rho (right) in frame 1, d4 along its z
        for shoulder in range(2 if rho > 0.0 else 1):
            side = -rho if shoulder == 0 else rho
            found |= wrists(t, r, q6_free, k, q, at, shoulder, (side * px - d4 * py) * scale,
                            (side * py + d4 * px) * scale, side)
        if attempt or found or rho > ABOVE_AXIS:
            break
        # above axis 1 rounding moves rho a lot; a little more of it may bring back into reach
        rho += 0.2 * ABOVE_AXIS
    return found


@kernel(R2, R1, R1, W2, B1, hot=True)
def solve(t, q6, k, q, valid):
    """All solutions of every pose; a single one has its slots in the code, many in ``valid``."""
    n = q.shape[0] // 8
    if t.shape[0] != 4 * n or t.shape[1] != 4:
        return BAD_SHAPE
    found = 0
    for i in range(n):
        if not is_rigid(t, 4 * i):
            return NOT_RIGID
        found = branches(t, 4 * i, q6[i] if q6.size > 1 else q6[0], k, q, 8 * i)
        if valid.size:
            for j in range(8):
                valid[8 * i + j] = found >> j & 1
                if not valid[8 * i + j]:
                    for joint in range(6):
                        q[8 * i + j, joint] = nan
    return 0 if valid.size else found
