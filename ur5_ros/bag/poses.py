"""Poses as messages have them: position and quaternion."""

from math import sqrt

import numpy as np


def position_and_quaternion(transform: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return a homogeneous transform as geometry_msgs/Pose holds it.

    Shepperd 1978: the largest of the four components is computed from a sum, the others by
    division through it, so that no rotation is ill-conditioned.

    Parameters
    ----------
    transform : numpy.ndarray, shape (4, 4)
        Pose [m].

    Returns
    -------
    position : numpy.ndarray, shape (3,)
        Position [m].
    quaternion : numpy.ndarray, shape (4,)
        x, y, z, w, of norm one, w not negative.

    """
    # floats, not arrays: a control loop asks, and NumPy would take ten times as long
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = transform[:3].tolist()
    squares = [1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i, 1.0 + a + e + i]
    largest = squares.index(max(squares))
    quaternion = [
        [squares[0], b + d, c + g, h - f],
        [b + d, squares[1], f + h, c - g],
        [c + g, f + h, squares[2], d - b],
        [h - f, c - g, d - b, squares[3]],
    ][largest]
    norm = sqrt(sum(component * component for component in quaternion))
    scale = 1.0 / norm if quaternion[3] >= 0.0 else -1.0 / norm
    return np.array([x, y, z]), np.array([scale * component for component in quaternion])
