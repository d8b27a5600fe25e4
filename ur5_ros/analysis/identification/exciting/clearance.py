"""How far an arm is from the table plane and from itself."""

import numpy as np

from ur5_ros.model.kinematics import link_transforms
from ur5_ros.model.parameters import ArmParameters


def clearance_of(angles: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return the least clearance of each state [m], shape (n,).

    Of elbow, wrists and tool above the base plane, of wrists and tool beside the base column, and
    of wrist 2 and tool beside the upper arm.

    """
    origin = link_transforms(angles, arm)[..., :3, 3]
    shoulder = np.zeros_like(origin[:, 0])
    shoulder[:, 2] = arm.d[0]
    column = [_distance(origin[:, i], np.zeros_like(shoulder), shoulder) for i in (3, 4, 5)]
    upper = [_distance(origin[:, i], shoulder, origin[:, 1]) for i in (4, 5)]
    return np.min([*origin[:, 1:, 2].T, *column, *upper], axis=0)


def _distance(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distance of points from segments, (n, 3) each."""
    along = b - a
    share = np.clip(np.sum((point - a) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(point - a - share[:, None] * along, axis=1)
