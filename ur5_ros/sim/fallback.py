"""What the motors do when no valid command does: brake, hold against gravity, or nothing."""

import numpy as np

from ur5_ros.model.friction import friction_terms
from ur5_ros.sim.bullet_arm import BulletArm, Joints
from ur5_ros.sim.friction import solve_friction
from ur5_ros.sim.integrator import Effects, tool_torque

#: Rate at which motion dies out under gravity compensation [1/s]; assumed: still in 0.2 s.
DAMPING_RATE = 20.0
_UNBOUNDED = np.full(6, np.inf)


def fallback_torque(mode: str, arm: BulletArm, joints: Joints, effects: Effects,
                    limit: np.ndarray, period: float) -> np.ndarray:
    """
    Return the torque of a fallback for one control period, within the torque limits.

    The brake knows the whole plant: payload, friction, wrench and gravity as they are; gravity
    compensation knows payload and gravity.

    ``mode``: ``brake``, ``gravity_compensation`` or ``zero_torque``; ``limit`` (6,): largest
    torque [N m]; ``period``: length of a control period [s].  Returned: joint torque [N m], (6,).
    """
    if mode == 'brake':
        return brake_torque(arm, joints, effects, limit, period)
    if mode == 'gravity_compensation':
        inertia = arm.mass_matrix(joints.q) + np.diag(effects.armature)
        rate = -np.expm1(-DAMPING_RATE * period) / period  # qd' = qd exp(-rate t), at any period
        tau = arm.bias(joints.q) - rate * (inertia @ joints.qd)
        return np.minimum(np.maximum(tau, -limit), limit)
    return np.zeros(6)


def brake_torque(arm: BulletArm, joints: Joints, effects: Effects, limit: np.ndarray,
                 period: float) -> np.ndarray:
    """
    Return the torque within the limits that minimises v'^T (M + Ia) v' after the period.

    That is dry friction of the size of the torque limits, taken at the new velocity.

    """
    qd = np.array(joints.qd)
    A = arm.mass_matrix(joints.q) / period
    load = arm.bias(joints.q, joints.qd) - tool_torque(arm, joints.q, effects)
    damping, level, offset = friction_terms(effects.friction, qd, load)
    A[np.diag_indices(6)] += effects.armature / period + damping
    drive = -load - damping * qd - offset
    _, f = solve_friction(A, drive, qd, limit + level, -_UNBOUNDED, _UNBOUNDED)
    return -np.minimum(np.maximum(f, -limit), limit)
