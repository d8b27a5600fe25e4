"""
Kinematics of a calibrated arm: the joint axes where one robot's own calibration puts them.

The chain is that of ur_description: frame i stands before joint i turns it about z.  The closed
form knows the DH table alone; here each of its solutions starts a Newton iteration on the chain.
Angles are the manufacturer's, q_UR; poses stand in ``base``.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ur5_ros.model.rotations import rotation_of_rpy, rotation_vector

if TYPE_CHECKING:
    from ur5_ros.model.parameters import ArmParameters

#: Pose error at which the iteration ends [m and rad], and its longest length.
TOLERANCE, MAX_ITERATIONS = 1e-13, 40

#: Damping near a singularity, falling with the square of the error, and the longest step [rad].
DAMPING, MAX_STEP = 1.0, 0.5

#: Two solutions nearer than this are one [rad].
SAME_SOLUTION = 1e-9


def transform(xyz: Sequence[float] | np.ndarray, rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the homogeneous transform of a position [m] and roll, pitch, yaw [rad]."""
    out = np.eye(4)
    roll, pitch, yaw = rpy
    out[:3, :3], out[:3, 3] = rotation_of_rpy(roll, pitch, yaw), xyz
    return out


def nominal_chain(arm: 'ArmParameters') -> np.ndarray:
    """Return the chain of an arm's DH table in the convention of ur_description, (6, 4, 4)."""
    half = 0.5 * np.pi
    return np.array([
        transform([0.0, 0.0, arm.d[0]], [0.0, 0.0, 0.0]),
        transform([0.0, 0.0, 0.0], [half, 0.0, 0.0]),
        transform([arm.a[1], 0.0, 0.0], [0.0, 0.0, 0.0]),
        transform([arm.a[2], 0.0, arm.d[3]], [0.0, 0.0, 0.0]),
        transform([0.0, -arm.d[4], 0.0], [half, 0.0, 0.0]),
        transform([0.0, arm.d[5], 0.0], [half, np.pi, np.pi])])


def chain_frames(q: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Return the frames 1 to 6 of a chain at q_UR (..., 6), shape (..., 6, 4, 4)."""
    cosine, sine = np.cos(q), np.sin(q)
    turn = np.zeros((*q.shape, 4, 4))
    turn[..., 0, 0] = turn[..., 1, 1] = cosine
    turn[..., 0, 1], turn[..., 1, 0] = -sine, sine
    turn[..., 2, 2] = turn[..., 3, 3] = 1.0
    steps = chain @ turn
    frames = np.empty(steps.shape)
    frame = steps[..., 0, :, :]
    for i in range(6):
        frame = frame if i == 0 else frame @ steps[..., i, :, :]
        frames[..., i, :, :] = frame
    return frames


def chain_jacobian(frames: np.ndarray) -> np.ndarray:
    """Return the geometric Jacobian of frame 6, linear rows first, shape (..., 6, 6)."""
    axes, origins = frames[..., :3, 2], frames[..., :3, 3]
    arms = origins[..., 5:6, :] - origins
    return np.swapaxes(np.concatenate([np.cross(axes, arms), axes], axis=-1), -1, -2)


def chain_jacobian_rate(frames: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Return dJ/dt of frame 6, rows as in :func:`chain_jacobian`."""
    axes, origins = frames[..., :3, 2], frames[..., :3, 3]
    spins = np.cumsum(axes * qd[..., None], axis=-2)  # of the frames
    steps = np.diff(origins, axis=-2)
    speeds = np.concatenate([np.zeros_like(origins[..., :1, :]), np.cumsum(
        np.cross(spins[..., :-1, :], steps), axis=-2)], axis=-2)
    axes_rate = np.cross(spins, axes)  # an axis moves with the frame that it turns
    arms, arms_rate = origins[..., 5:6, :] - origins, speeds[..., 5:6, :] - speeds
    linear = np.cross(axes_rate, arms) + np.cross(axes, arms_rate)
    return np.swapaxes(np.concatenate([linear, axes_rate], axis=-1), -1, -2)


def link_offsets(arm: 'ArmParameters', dh_frames: np.ndarray) -> np.ndarray:
    """Return DH frame i seen from chain frame i, (6, 4, 4), from the DH frames at q_UR = 0."""
    return np.linalg.inv(chain_frames(np.zeros(6), nominal_chain(arm))) @ dh_frames


def solve_from(T: np.ndarray, start: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """
    Return q_UR of poses by Newton's method, NaN where it does not reach them.

    ``T`` (n, 4, 4): poses [m]; ``start`` (n, 6): where each iteration begins [rad]; NaN where
    there is no start; ``chain`` (6, 4, 4): the calibrated chain.  Returned: joint positions [rad],
    in the turns of the start, within 1e-13 m and rad of the pose, (n, 6).
    """
    found = np.full(start.shape, np.nan)
    rows = np.flatnonzero(np.isfinite(start).all(axis=1))
    q, best = start[rows], np.full(len(rows), np.inf)
    for _ in range(MAX_ITERATIONS):
        frames = chain_frames(q, chain)
        error = _pose_error(T[rows], frames[:, 5])
        size = np.abs(error).max(axis=1)
        found[rows[size <= TOLERANCE]] = q[size <= TOLERANCE]
        # the last step only turns rounding over, so a pose met to the last bits is left
        left = (size > TOLERANCE) & (size < 1e3 * np.maximum(best, 1e-3))
        if not left.any():
            break
        rows, q, best = rows[left], q[left], np.minimum(best, size)[left]
        J = chain_jacobian(frames[left])
        normal = np.swapaxes(J, 1, 2) @ J + DAMPING * (size[left]**2)[:, None, None] * np.eye(6)
        step = np.linalg.solve(normal, np.swapaxes(J, 1, 2) @ error[left][..., None])[..., 0]
        q = q + np.clip(step, -MAX_STEP, MAX_STEP)
    return found


def _pose_error(T: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return position and rotation from poses to others, in base, shape (n, 6)."""
    turn = T[:, :3, :3] @ np.swapaxes(pose[:, :3, :3], -1, -2)
    return np.concatenate([T[:, :3, 3] - pose[:, :3, 3], rotation_vector(turn)], axis=1)


def distinct(q: np.ndarray) -> np.ndarray:
    """Return which rows of (n, 6) are the first of their kind, turns aside; NaN is none."""
    keep = np.isfinite(q).all(axis=1)
    for i in range(len(q)):
        gap = np.abs((q[:i][keep[:i]] - q[i] + np.pi) % (2.0 * np.pi) - np.pi)
        if keep[i] and len(gap) and (gap.max(axis=1) < SAME_SOLUTION).any():
            keep[i] = False
    return keep
