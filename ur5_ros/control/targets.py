"""Targets: positions with quaternions as poses, and poses turned into joint targets."""

from collections.abc import Sequence
from math import hypot

import numpy as np

from ur5_ros.control.tool_motion import Branch, singularity_distance
from ur5_ros.errors import InputError
from ur5_ros.model.inverse_kinematics import inverse_kinematics, nearest_solution
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import rotation_of_quaternion
from ur5_ros.signals import JOINT_NAMES

#: How far the norm of a quaternion may be from one: single precision and some.
QUATERNION_TOLERANCE = 1e-3


def pose_matrix(position: Sequence[float], quaternion: Sequence[float]) -> np.ndarray:
    """
    Return the homogeneous transform of a position and a quaternion.

    ``position``: x, y, z [m].  Returned: the transform, (4, 4).
    """
    p = np.array(position, dtype=float)
    quat = np.array(quaternion, dtype=float)
    if not (np.all(np.isfinite(p)) and np.all(np.isfinite(quat))):
        raise InputError(f'pose {p.tolist()}, {quat.tolist()} holds a number that is not finite')
    norm = hypot(*quat)
    if abs(norm - 1.0) > QUATERNION_TOLERANCE:
        raise InputError(f'the quaternion [{", ".join(f"{v:g}" for v in quat)}] has the norm '
                         f'{norm:.6g}; give one of norm 1 (x, y, z, w)')
    transform = np.eye(4)
    transform[:3, :3] = rotation_of_quaternion(quat / norm)
    transform[:3, 3] = p
    return transform


def solve_pose(
    transform: np.ndarray,
    near: np.ndarray,
    arm: ArmParameters,
    max_joint_jump: float,
) -> tuple[np.ndarray, Branch]:
    """
    Return the joint target for a pose: the branch and wraps nearest to a configuration.

    ``transform`` (4, 4): tool pose in ``base``; ``near`` (6,): present configuration,
    manufacturer's angles [rad]; ``max_joint_jump``: largest motion of a joint that is accepted
    [rad].  Returned: joint target, manufacturer's angles [rad], (6,).
    """
    offset = arm.angle_offset
    target = nearest_solution(transform, near + offset, arm)
    solutions = inverse_kinematics(transform, arm, q_near=near + offset)
    away = (solutions.q - target) / (2.0 * np.pi)
    label = solutions.branch[np.abs(away - np.round(away)).max(axis=1).argmin()]
    distance = np.abs(target - offset - near)
    if distance.max() > max_joint_jump:
        joint = int(distance.argmax())
        raise InputError(f'{JOINT_NAMES[joint]} would have to turn by '
                         f'{distance[joint]:.4f} rad to the nearest solution; max_joint_jump is '
                         f'{max_joint_jump:g}: go there in steps, or by ~/target_joints')
    q = target - offset
    return q, Branch(int(label), len(solutions.q), float(singularity_distance(q, arm)))
