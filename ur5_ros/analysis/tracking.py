"""Tracking: joints and tool against the reference, the paper's Fig. 11 in numbers."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.residual import CHUNK
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import rotation_vector


class ToolTracking(NamedTuple):
    """Tool pose, desired and reached, in ``base``."""

    position: np.ndarray
    """Position reached [m], shape (n, 3)."""
    desired_position: np.ndarray
    """Desired position [m], shape (n, 3); NaN without a reference."""
    orientation: np.ndarray
    """Rotation vector of the orientation reached [rad], shape (n, 3)."""
    desired_orientation: np.ndarray
    """Rotation vector of the desired orientation [rad], shape (n, 3)."""
    distance: np.ndarray
    """Distance between the two positions [m], shape (n,)."""
    angle: np.ndarray
    """Angle between the two orientations [rad], shape (n,)."""


def tool_tracking(run: Run, arm: ArmParameters, desired_arm: ArmParameters) -> ToolTracking:
    """Return the poses of ``arm``, the desired ones of ``desired_arm``, and the errors."""
    made = forward_kinematics(run.exact.q + arm.angle_offset, arm)
    star = np.full(run.exact.q.shape, np.nan) if run.reference is None else run.reference.q
    known = np.isfinite(star).all(axis=1)
    desired = np.full(made.shape, np.nan)
    desired[known] = forward_kinematics(star[known] + desired_arm.angle_offset, desired_arm)
    distance, angle = np.full((2, len(made)), np.nan)
    desired_vector = np.full((len(made), 3), np.nan)
    vector = continuous_vectors(rotation_vector(made[:, :3, :3]))
    if known.any():
        distance[known], angle[known] = _pose_errors(made[known], desired[known])
        desired_vector[known] = continuous_vectors(rotation_vector(desired[known, :3, :3]))
        vector = _same_sheet(vector, desired_vector, int(np.argmax(known)))
    return ToolTracking(made[:, :3, 3], desired[:, :3, 3], vector, desired_vector, distance, angle)


def tool_errors(
    q: np.ndarray, desired: np.ndarray, arm: ArmParameters,
) -> tuple[np.ndarray, np.ndarray]:
    """Return distance [m] and angle [rad] between the tool poses of joint positions, (n,) each."""
    distance, angle = np.empty((2, len(q)))
    for start in range(0, len(q), CHUNK):
        rows = slice(start, start + CHUNK)
        a, b = (forward_kinematics(each[rows] + arm.angle_offset, arm) for each in (q, desired))
        distance[rows], angle[rows] = _pose_errors(a, b)
    return distance, angle


def _pose_errors(made: np.ndarray, desired: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    turn = np.einsum('nji,njk->nik', desired[:, :3, :3], made[:, :3, :3])
    return (np.linalg.norm(made[:, :3, 3] - desired[:, :3, 3], axis=1),
            np.linalg.norm(rotation_vector(turn), axis=1))


def continuous_vectors(vectors: np.ndarray) -> np.ndarray:
    """
    Return rotation vectors made continuous along the rows: beyond pi instead of turning over.

    ``vectors`` (n, 3): rotation vectors, angle 0 to pi [rad].
    """
    length = np.linalg.norm(vectors, axis=1)
    flip = np.concatenate([[False], (np.einsum('ni,ni->n', vectors[1:], vectors[:-1]) < 0.0)
                           & (length[1:] > 2.0) & (length[:-1] > 2.0)])
    odd = np.cumsum(flip) % 2 == 1
    out = vectors.copy()
    out[odd] = _other_sheet(vectors[odd])
    return out


def _other_sheet(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors * (1.0 - 2.0 * np.pi / np.maximum(length, 1e-300))


def _same_sheet(vectors, desired, row):
    other = _other_sheet(vectors)
    near = np.linalg.norm(vectors[row] - desired[row]) <= np.linalg.norm(other[row] - desired[row])
    return vectors if near else other
