"""Rotations: matrices, quaternions (x, y, z, w), rotation vectors and angles about axes."""

from math import sqrt

import numpy as np


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """
    Return the quaternion of a rotation matrix.

    Shepperd 1978: the largest of the four components is computed from a sum, the others by
    division through it, so that no rotation is ill-conditioned.

    ``rotation`` (3, 3): rotation matrix.  Returned: x, y, z, w, of norm one, w not negative, (4,).
    """
    # floats, not arrays: NumPy would take ten times as long, and control loops call this
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
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
    return np.array([scale * component for component in quaternion])


def position_and_quaternion(transform: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return a homogeneous transform as geometry_msgs/Pose holds it.

    ``transform`` (4, 4): pose [m].  Returned: ``position`` (3,): position [m]; ``quaternion``
    (4,): as :func:`quaternion_of` returns it.
    """
    return transform[:3, 3].copy(), quaternion_of(transform[:3, :3])


def rotation_of_quaternion(quaternion: np.ndarray) -> np.ndarray:
    """
    Return the rotation matrix of a quaternion.

    ``quaternion`` (4,): x, y, z, w, of norm one.  Returned: rotation matrix, (3, 3).
    """
    x, y, z, w = quaternion
    return np.array([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ])


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """
    Return axis times angle of rotation matrices, well conditioned for every angle.

    ``rotation`` (n, 3, 3): rotation matrices.  Returned: rotation vectors [rad], angle 0 to pi,
    (n, 3).
    """
    r = rotation
    twice_sine = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0],
                           r[:, 1, 0] - r[:, 0, 1]], axis=-1)
    sine = np.linalg.norm(twice_sine, axis=1) / 2.0
    cosine = (np.trace(r, axis1=1, axis2=2) - 1.0) / 2.0
    angle = np.arctan2(sine, cosine)
    ratio = np.divide(angle, sine, out=np.ones_like(angle), where=sine > 0.0)
    vector = twice_sine / 2.0 * ratio[:, None]
    wide, = np.nonzero(~(cosine > 0.0))  # there the sine says little about a small change
    square = ((r[wide] + np.swapaxes(r[wide], 1, 2)) / 2.0
              - cosine[wide, None, None] * np.eye(3))  # (1 - cos) axis axis^T
    largest = np.diagonal(square, axis1=1, axis2=2).argmax(axis=1)
    column = np.take_along_axis(square, largest[:, None, None], axis=2)[:, :, 0]
    axis = column / np.linalg.norm(column, axis=1, keepdims=True)
    along = (twice_sine[wide] * axis).sum(axis=1, keepdims=True)
    vector[wide] = angle[wide, None] * np.where(along >= 0.0, axis, -axis)
    return vector


def rotation_about(axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """
    Return the rotations about unit axes by angles (Rodrigues' formula).

    ``axis`` (..., 3): unit vectors; zero for no rotation; ``angle`` (...): angles [rad].
    Returned: rotation matrices, (..., 3, 3).
    """
    x, y, z = np.moveaxis(np.asarray(axis, dtype=float), -1, 0)
    sine, versine = np.sin(angle), 2.0 * np.sin(np.asarray(angle) / 2.0) ** 2
    return _matrix(
        (1.0 - versine * (y * y + z * z), versine * x * y - sine * z, versine * x * z + sine * y),
        (versine * x * y + sine * z, 1.0 - versine * (x * x + z * z), versine * y * z - sine * x),
        (versine * x * z - sine * y, versine * y * z + sine * x, 1.0 - versine * (x * x + y * y)))


def rotation_of_rpy(
    roll: np.ndarray | float, pitch: np.ndarray | float, yaw: np.ndarray | float,
) -> np.ndarray:
    """
    Return Rz(yaw) Ry(pitch) Rx(roll).

    ``roll``, ``pitch``, ``yaw`` (...): angles about the fixed axes x, y, z, in this order [rad].
    Returned: rotation matrices, (..., 3, 3).
    """
    sa, ca = np.sin(roll), np.cos(roll)
    sb, cb = np.sin(pitch), np.cos(pitch)
    sc, cc = np.sin(yaw), np.cos(yaw)
    return _matrix((cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa),
                   (sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa),
                   (-sb, cb * sa, cb * ca))


def _matrix(*rows: tuple) -> np.ndarray:
    """Return matrices (..., 3, 3) from rows of entries that broadcast."""
    entries = np.broadcast_arrays(*(entry for row in rows for entry in row))
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, 3, 3)
