"""Inverse kinematics along a path: one branch, followed without a jump."""

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.angle_wrapping import limits_of_model
from ur5_ros.model.inverse_kinematics import nearest_solution
from ur5_ros.model.kernels import path as path_kernel
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.parameters import ArmParameters, Limits
from ur5_ros.model.poses import check_pose, unreachable


def follow_path(
    T: np.ndarray, q_start: np.ndarray, arm: ArmParameters, limits: Limits | None = None,
    max_step: float = 0.2,
) -> np.ndarray:
    """
    Return joint configurations along a path of poses, each nearest to the one before.

    Where joint 6 is free it is kept still.

    Parameters
    ----------
    T : array_like, shape (n, 4, 4)
        Poses of ``tool0`` in ``base`` [m], close enough to each other that no joint turns more
        than ``max_step`` between two.
    q_start : array_like, shape (6,)
        The first configuration is the one nearest to this, turns by 2 pi included [rad].
    arm : ArmParameters
        The arm.
    limits : Limits, optional
        Position limits in the manufacturer's angles (``arm.angle_offset`` is added here); those
        of the arm by default.
    max_step : float
        Largest change of a joint between two poses [rad]; a larger one is a jump to another
        branch, or a path through a singularity.

    Returns
    -------
    numpy.ndarray, shape (n, 6)
        Joint positions, angles of the arm record [rad]; not wrapped.

    Raises
    ------
    InputError
        If a pose is no rigid transform, out of reach, or reached only outside the limits or by a
        jump; the message names the pose.

    """
    poses = finite_array('T', T, (4, 4))
    if poses.ndim != 3 or len(poses) == 0:
        raise InputError(f'T has shape {poses.shape}; give (n, 4, 4) with n at least 1')
    if not max_step > 0.0:
        raise InputError(f'max_step is {max_step} rad; give more than zero')
    limits = arm.limits if limits is None else limits
    lower, upper = limits_of_model(arm, limits)
    first = nearest_solution(poses[0], q_start, arm, limits)
    rows = np.empty((len(poses), 7))
    path_kernel.follow.prepare()
    path_kernel.follow.single(poses.reshape(-1, 4), first, lower, upper, arm.constants, rows)
    q, met = np.ascontiguousarray(rows[:, :6]), rows[:, 6]
    step = np.zeros_like(q)
    step[1:] = np.abs(np.diff(q, axis=0))
    bad = (met != 0.0) | (step.max(axis=1) > max_step)
    if bad.any():
        raise InputError(_trouble(int(np.argmax(bad)), poses, met, q, step, limits, arm, max_step))
    return q


def _trouble(i: int, poses: np.ndarray, met: np.ndarray, q: np.ndarray, step: np.ndarray,
             limits: Limits, arm: ArmParameters, max_step: float) -> str:
    if met[i] == -1.0:
        check_pose(poses)
    if met[i] == 1.0:
        return f'pose {i} of the path is {unreachable(poses[i], arm)}'
    if met[i] == 2.0:
        wanted = q[i] - arm.angle_offset
        joint = int(np.argmax(np.maximum(limits.lower - wanted, wanted - limits.upper)))
        return (f'pose {i} of the path lies outside the limits: joint {joint + 1} would stand at '
                f'{wanted[joint]:.4f} rad, limits {limits.lower[joint]:.4f} to '
                f'{limits.upper[joint]:.4f} rad; start a turn away or give another path')
    joint = int(np.argmax(step[i]))
    return (f'pose {i} of the path needs a jump: joint {joint + 1} would turn '
            f'{step[i, joint]:.4f} rad at once, at most {max_step:g} is allowed; give closer '
            'poses, or a path that stays away from singularities')
