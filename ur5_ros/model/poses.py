"""Poses as arguments: what is no rigid transform, and what no arm can reach."""

import numpy as np

from ur5_ros.errors import Refusal
from ur5_ros.model.arguments import finite_array
from ur5_ros.model.inverse_kernels import RIGID
from ur5_ros.model.parameters import ArmParameters


def single_pose(T: np.ndarray) -> np.ndarray:
    """
    Return one pose as an array of shape (4, 4).

    Raises
    ------
    Refusal
        If it is not one, or a number is not finite.

    """
    pose = finite_array('T', T, (4, 4))
    if pose.ndim != 2:
        raise Refusal(f'T has shape {pose.shape}; give (4, 4), one pose')
    return pose


def check_pose(T: np.ndarray) -> None:
    """
    Refuse what is no rigid transform, and say by how much.

    Parameters
    ----------
    T : array_like, shape (..., 4, 4)
        Poses.

    Raises
    ------
    Refusal
        If a number is not finite, the last row is not (0, 0, 0, 1) or the rest no rotation.

    """
    poses = finite_array('T', T, (4, 4))
    rotation = poses[..., :3, :3]
    flat = poses.reshape(-1, 4, 4)
    last = np.abs(flat[:, 3] - (0.0, 0.0, 0.0, 1.0)).max(axis=1, initial=0.0)
    gram = np.abs(rotation @ np.swapaxes(rotation, -1, -2) - np.eye(3)).reshape(-1, 9).max(axis=1)
    which = '' if poses.ndim == 2 else ' {}'
    for what, defect in (('its last row differs from (0, 0, 0, 1) by', last),
                         ('R R^T differs from 1 by', gram)):
        worst = int(np.argmax(defect))
        if defect[worst] > RIGID:
            raise Refusal(f'T{which.format(worst)} is no rigid transform: {what} '
                          f'{defect[worst]:.3g}; at most {RIGID:g} is taken as rounding')
    determinant = np.linalg.det(flat[:, :3, :3])
    worst = int(np.argmin(determinant))
    if determinant[worst] < 1.0 - 4.0 * RIGID:
        raise Refusal(f'T{which.format(worst)} is no rigid transform: det R is '
                      f'{determinant[worst]:.6g}; give +1')


def unreachable(T: np.ndarray, arm: ArmParameters) -> str:
    """
    Return in one sentence why an arm cannot reach a pose.

    Parameters
    ----------
    T : numpy.ndarray, shape (4, 4)
        A pose without solution.
    arm : ArmParameters
        The arm.

    """
    p5 = T[:3, 3] - arm.d[5] * T[:3, 2]
    across = float(np.hypot(p5[0], p5[1]))
    if across < abs(arm.d[3]):
        return (f'out of reach: the origin of frame 5 lies {across:.6g} m from axis 1; '
                f'at least |d4| = {abs(arm.d[3]):.6g} m is needed')
    reach = abs(arm.a[1]) + abs(arm.a[2])
    hole = abs(abs(arm.a[1]) - abs(arm.a[2]))
    height = p5[2] - arm.d[0]
    span = np.hypot(np.sqrt(across ** 2 - arm.d[3] ** 2), height)
    return (f'out of reach: the wrist lies about {span:.6g} m from the shoulder, give or take '
            f'|d5| = {abs(arm.d[4]):.6g} m; joints 2 and 3 span {hole:.6g} to {reach:.6g} m')
