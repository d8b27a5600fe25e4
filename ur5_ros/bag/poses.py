"""Poses as messages have them: position and quaternion."""

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
    m = transform[:3, :3]
    squares = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2],
                        1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + m[0, 0] + m[1, 1] + m[2, 2]])
    products = np.array([
        [0.0, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
        [m[0, 1] + m[1, 0], 0.0, m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
        [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 0.0, m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 0.0]])
    largest = int(squares.argmax())
    quaternion = products[largest].copy()
    quaternion[largest] = squares[largest]
    quaternion /= np.linalg.norm(quaternion)
    return transform[:3, 3].copy(), quaternion if quaternion[3] >= 0.0 else -quaternion
