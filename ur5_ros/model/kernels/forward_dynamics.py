"""Kernel of the forward dynamics: M by columns, its factors L D L^T, and the acceleration."""

from math import isfinite

from ur5_ros.model.kernels.base_parameters import ARMATURE
from ur5_ros.model.kernels.compiled import R1, W1, inlined, kernel
from ur5_ros.model.kernels.dynamics import mass_columns
from ur5_ros.model.kernels.newton_euler import torque_of_motion
from ur5_ros.model.kernels.plane_geometry import axes, bodies, gravity_in_plane, total


@inlined
def acceleration_of_state(q, qd, tau, k, qdd, at):
    """Write the joint acceleration of one state; return its sum, not finite if M is singular."""
    turns, origins, lines = axes(q, at, k)
    in_plane = bodies(turns, origins, k)
    for i in range(6):
        qdd[at + i] = 0.0
    b1, b2, b3, b4, b5, b6 = torque_of_motion(
        in_plane, lines, qd, qdd, at, gravity_in_plane(q[at], k), k)
    d1, c2, c3, c4, c5, c6 = mass_columns(in_plane, lines, k)
    x1, x2, x3 = tau[at] - b1, tau[at + 1] - b2, tau[at + 2] - b3
    x4, x5, x6 = tau[at + 3] - b4, tau[at + 4] - b5, tau[at + 5] - b6
    # from the tool to the shoulder: column j of M over its diagonal leaves a smaller system
    d6 = c6[5] + k[ARMATURE + 5]
    l1, l2, l3, l4, l5 = c6[0] / d6, c6[1] / d6, c6[2] / d6, c6[3] / d6, c6[4] / d6
    x1, x2, x3, x4, x5 = x1 - l1 * x6, x2 - l2 * x6, x3 - l3 * x6, x4 - l4 * x6, x5 - l5 * x6
    e1, e2, e3 = c5[0] - l1 * c6[4], c5[1] - l2 * c6[4], c5[2] - l3 * c6[4]
    e4, d5 = c5[3] - l4 * c6[4], c5[4] + k[ARMATURE + 4] - l5 * c6[4]
    f1, f2, f3 = c4[0] - l1 * c6[3], c4[1] - l2 * c6[3], c4[2] - l3 * c6[3]
    d4 = c4[3] + k[ARMATURE + 3] - l4 * c6[3]
    g1, g2, d3 = c3[0] - l1 * c6[2], c3[1] - l2 * c6[2], c3[2] + k[ARMATURE + 2] - l3 * c6[2]
    h1, d2 = c2[0] - l1 * c6[1], c2[1] + k[ARMATURE + 1] - l2 * c6[1]
    d1 = d1 - l1 * c6[0]
    k1, k2, k3, k4 = e1 / d5, e2 / d5, e3 / d5, e4 / d5
    x1, x2, x3, x4 = x1 - k1 * x5, x2 - k2 * x5, x3 - k3 * x5, x4 - k4 * x5
    f1, f2, f3, d4 = f1 - k1 * e4, f2 - k2 * e4, f3 - k3 * e4, d4 - k4 * e4
    g1, g2, d3 = g1 - k1 * e3, g2 - k2 * e3, d3 - k3 * e3
    h1, d2, d1 = h1 - k1 * e2, d2 - k2 * e2, d1 - k1 * e1
    p1, p2, p3 = f1 / d4, f2 / d4, f3 / d4
    x1, x2, x3 = x1 - p1 * x4, x2 - p2 * x4, x3 - p3 * x4
    g1, g2, d3 = g1 - p1 * f3, g2 - p2 * f3, d3 - p3 * f3
    h1, d2, d1 = h1 - p1 * f2, d2 - p2 * f2, d1 - p1 * f1
    r1, r2 = g1 / d3, g2 / d3
    x1, x2 = x1 - r1 * x3, x2 - r2 * x3
    h1, d2, d1 = h1 - r1 * g2, d2 - r2 * g2, d1 - r1 * g1
    s1 = h1 / d2
    # and back
    a1 = (x1 - s1 * x2) / (d1 - s1 * h1)
    a2 = x2 / d2 - s1 * a1
    a3 = x3 / d3 - r1 * a1 - r2 * a2
    a4 = x4 / d4 - p1 * a1 - p2 * a2 - p3 * a3
    a5 = x5 / d5 - k1 * a1 - k2 * a2 - k3 * a3 - k4 * a4
    qdd[at], qdd[at + 1], qdd[at + 2], qdd[at + 3] = a1, a2, a3, a4
    qdd[at + 4] = a5
    qdd[at + 5] = x6 / d6 - l1 * a1 - l2 * a2 - l3 * a3 - l4 * a4 - l5 * a5
    return total(qdd, at)


@kernel(R1, R1, R1, R1, W1, hot=True)
def forward(q, qd, tau, k, qdd):
    """Joint acceleration of every state under torque."""
    if q.size != qdd.size or qd.size != qdd.size or tau.size != qdd.size:
        return 1
    for at in range(0, qdd.size, 6):
        if not isfinite(acceleration_of_state(q, qd, tau, k, qdd, at)):
            return 1
    return 0

