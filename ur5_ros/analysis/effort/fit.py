"""What a torque leaves of an effort, friction beside it: the fit under every meaning."""

import numpy as np

from ur5_ros.analysis.residual_blocks import SampleBlocks
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: A fit is clearly better that leaves at most this share of what another one leaves.
CLEARLY_BETTER = 0.5

#: A joint whose effort is below this share of the largest one does not decide, and what it leaves
#: weighs as if it were this share.
SMALL_SHARE, LEAST_SCALE = 0.02, 0.05


def torque_of(samples: SampleBlocks, arm: ArmParameters) -> np.ndarray:
    """Return the block means of the inverse dynamics of an arm, shape (b, 6)."""
    return inverse_dynamics(samples.q, samples.qd, samples.qdd, arm).mean(axis=1)


def friction_columns(samples: SampleBlocks) -> np.ndarray:
    """Return the block means of qd and sign(qd), shape (b, 6, 2); zero where a joint rests."""
    qd = samples.qd_next
    moving = np.where(np.abs(qd) > 1e-3, qd, 0.0)
    return np.stack([moving.mean(axis=1), np.sign(moving).mean(axis=1)], axis=-1)


def unexplained(effort: np.ndarray, torque: np.ndarray, samples: SampleBlocks,
                constant: bool = False) -> np.ndarray:
    """
    Return the effort less a torque and less friction that opposes the motion, (b, 6).

    ``constant``: whether each joint may have a constant torque besides.
    """
    left, columns = effort - torque, friction_columns(samples)
    for joint in range(6):
        x = columns[:, joint]
        if np.abs(x).max() > 0.0:
            ones = np.ones((len(x), int(constant)))
            value, *_ = np.linalg.lstsq(np.hstack([x, ones]), left[:, joint], rcond=None)
            left[:, joint] -= x @ np.maximum(value[:2], 0.0)
        if constant:
            left[:, joint] -= left[:, joint].mean()
    return left


def relative_size(left: np.ndarray, effort: np.ndarray, least: float = 0.0) -> float:
    """Return the RMS of what is left, relative to each joint's effort."""
    scale = np.sqrt(np.mean(effort**2, axis=0))
    scale = np.maximum(scale, max(LEAST_SCALE * float(scale.max()), least, 1e-12))
    return float(np.sqrt(np.mean((left / scale)**2)))


def misfit_of(effort: np.ndarray, torque: np.ndarray, samples: SampleBlocks,
              least: float = 0.0) -> float:
    """Return what a torque leaves of an effort beside friction, relative to each joint's."""
    return relative_size(unexplained(effort, torque, samples), effort, least)


def fit_current(effort, torque, samples: SampleBlocks,
                constant: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the factor of each joint [N m/A] and the effort of the fit, shape (b, 6).

    ``constant``: whether a constant current may be added to each.
    """
    columns, factors, model = friction_columns(samples), np.full(6, np.nan), np.zeros_like(effort)
    large = deciding_joints(effort)
    for joint in range(6):
        x = np.column_stack([torque[:, joint], columns[:, joint]])
        if not np.abs(x[:, 1:]).max() > 0.0:
            x = x[:, :1]
        if constant:
            x = np.column_stack([x, np.ones(len(x))])
        value, *_ = np.linalg.lstsq(x, effort[:, joint], rcond=None)
        model[:, joint] = x @ value
        if large[joint] and value[0]:
            factors[joint] = 1.0 / value[0]
    return factors, model


def deciding_joints(effort: np.ndarray) -> np.ndarray:
    """Return which joints have an effort large enough to decide, shape (6,)."""
    scale = np.sqrt(np.mean(effort**2, axis=0))
    return scale > SMALL_SHARE * scale.max()
