"""Poses as arguments: what is no rigid transform, and what no arm can reach."""

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.kernels.inverse_kinematics import RIGID_TOLERANCE
from ur5_ros.model.parameters import ArmParameters


def single_pose(T: np.ndarray) -> np.ndarray:
    """Return one pose as an array of shape (4, 4)."""
    pose = finite_array('T', T, (4, 4))
    if pose.ndim != 2:
        raise InputError(f'T has shape {pose.shape}; give (4, 4), one pose')
    return pose


def check_pose(T: np.ndarray) -> None:
    """
    Refuse what is no rigid transform, with the size of its error.

    ``T`` (..., 4, 4): poses.
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
        if defect[worst] > RIGID_TOLERANCE:
            raise InputError(f'T{which.format(worst)} is no rigid transform: {what} '
                             f'{defect[worst]:.3g}; at most {RIGID_TOLERANCE:g} is taken as '
                             'rounding')
    determinant = np.linalg.det(flat[:, :3, :3])
    worst = int(np.argmin(determinant))
    if determinant[worst] < 1.0 - 4.0 * RIGID_TOLERANCE:
        raise InputError(f'T{which.format(worst)} is no rigid transform: det R is '
                         f'{determinant[worst]:.6g}; give +1')


def unreachable(T: np.ndarray, arm: ArmParameters) -> str:
    """
    Return in one sentence why an arm cannot reach a pose.

    ``T`` (4, 4): A pose without solution.
    """
    p5 = T[:3, 3] - arm.d[5] * T[:3, 2]
    across = float(np.hypot(p5[0], p5[1]))
    if across < abs(arm.d[3]):
        return (f'out of reach: the origin of frame 5 lies {across:.6g} m from axis 1; '
                f'at least |d4| = {abs(arm.d[3]):.6g} m is needed')
    spans = np.array([_span(T, p5, side * np.sqrt(across ** 2 - arm.d[3] ** 2), flip, arm)
                      for side in (-1.0, 1.0) for flip in (-1.0, 1.0)])
    reach = abs(arm.a[1]) + abs(arm.a[2])
    hole = abs(abs(arm.a[1]) - abs(arm.a[2]))
    span = spans[np.argmin(np.maximum(spans - reach, hole - spans))]
    return (f'out of reach by {max(span - reach, hole - span):.3g} m: the nearest branch needs a '
            f'span of {span:.6g} m from shoulder to wrist; joints 2 and 3 span {hole:.6g} to '
            f'{reach:.6g} m')


def _span(T: np.ndarray, p5: np.ndarray, side: float, flip: float, arm: ArmParameters) -> float:
    # from axis 2 to axis 4 in the plane of the arm, for one shoulder and wrist
    c1, s1 = side * p5[0] - arm.d[3] * p5[1], side * p5[1] + arm.d[3] * p5[0]
    c1, s1 = np.array([c1, s1]) / np.hypot(c1, s1)
    yn, yo = c1 * T[1, :2] - s1 * T[0, :2]
    s5 = max(np.hypot(yn, yo), 1e-12)
    p4 = p5 + arm.d[4] * flip * (yo * T[:3, 0] - yn * T[:3, 1]) / s5
    return float(np.hypot(c1 * p4[0] + s1 * p4[1], p4[2] - arm.d[0]))
