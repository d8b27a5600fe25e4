"""Motion of the links in the plane of the arm, and the torque that it takes (Newton, Euler)."""

from ur5_ros.model.kernels.base_parameters import SHOULDER, SPIN
from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.model.kernels.composite_inertia import moment
from ur5_ros.model.kernels.plane_geometry import add, add_scaled, cross, dot

Z = (0.0, 0.0, 1.0)
NIL = (0.0, 0.0, 0.0)


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
