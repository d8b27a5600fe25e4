"""Targets: poses and frames checked, poses turned into joint targets."""

from collections.abc import Sequence
from math import hypot

import numpy as np

from ur5_ros.control.tool_motion import Branch, singularity_distance
from ur5_ros.errors import InputError
from ur5_ros.model.inverse_kinematics import inverse_kinematics, nearest_solution
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import rotation_of_quaternion
from ur5_ros.signals import JOINT_NAMES, checked_wrench

#: How far the norm of a quaternion may be from one: single precision and some.
QUATERNION_TOLERANCE = 1e-3
#: No pose is further away [m].
_LARGEST_DISTANCE = 1e6
#: base_link = base turned by Rz(pi) (REP-103).
_BASE_FROM_BASE_LINK = np.diag([-1.0, -1.0, 1.0, 1.0])


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


def wrench_in_base(force: Sequence[float], torque: Sequence[float], frame: str, prefix: str,
                   q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return force [N] and torque [N m] at the origin of ``tool0`` in the axes of ``base``, (6,).

    ``force``, ``torque`` (3,): in the axes of ``frame``; ``frame``: ``base`` (also if it is
    empty), ``base_link`` or ``tool0``; ``prefix``: ``tf_prefix``; ``q`` (6,): where the arm stands
    [rad], for ``tool0``.
    """
    wrench = checked_wrench(force, torque)
    if frame in ('', prefix + 'base'):
        return wrench.ravel()
    if frame == prefix + 'base_link':
        return (wrench @ _BASE_FROM_BASE_LINK[:3, :3].T).ravel()
    if frame == prefix + 'tool0':
        turn = forward_kinematics(q + arm.angle_offset, arm)[:3, :3]
        return (wrench @ turn.T).ravel()
    raise InputError(f'wrench in frame {frame[:60]!r}; give {prefix}base, {prefix}base_link or '
                     f'{prefix}tool0')


def in_base(transform: np.ndarray, frame: str, prefix: str = '') -> np.ndarray:
    """
    Return a pose given in ``base`` or ``base_link`` in ``base``.

    ``transform`` (..., 4, 4): the pose; ``prefix``: ``tf_prefix``.  Returned: in ``base``, (...,
    4, 4).
    """
    transform = np.asarray(transform, dtype=float)
    if transform.shape[-2:] != (4, 4) or not np.all(np.isfinite(transform)):
        raise InputError(f'pose of shape {transform.shape}; give finite (4, 4) transforms')
    if np.abs(transform).max(initial=0.0) > _LARGEST_DISTANCE:
        raise InputError(f'pose with {np.abs(transform).max():.6g} in it; give metres')
    rotation = transform[..., :3, :3]
    product = np.matmul(rotation, np.swapaxes(rotation, -1, -2))
    skewness = float(np.abs(product - np.eye(3)).max(initial=0.0))
    if skewness > 1e-6 or np.any(np.linalg.det(rotation) < 0.0):
        raise InputError(f'the rotation is off by {skewness:.3g} from an orthonormal right-handed '
                         'matrix; give a rotation')
    if frame == prefix + 'base':
        return transform
    if frame == prefix + 'base_link':
        return np.matmul(_BASE_FROM_BASE_LINK, transform)
    raise InputError(f'frame {frame!r} is not known; give the pose in {prefix}base or '
                     f'{prefix}base_link')


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
