"""Friction beside viscous and Coulomb: its decay with speed, and what holds a joint at rest."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ur5_ros.analysis.diagnosis.selection import Causes, Fit
from ur5_ros.analysis.residual_blocks import (
    SampleBlocks,
    is_noise,
    sliding,
    sticking,
    stribeck_torque,
)
from ur5_ros.signals import JOINT_NAMES

#: Speeds at which friction above Coulomb may have decayed to 1/e [rad/s]; what decays below the
#: first is felt at rest alone.
SLOWEST_DECAY, FASTEST_DECAY = 0.01, 2.0

#: Static friction is named from this share of what holds the joint, and from this torque on [N m].
STICTION_SHARE, LEAST_STICTION = 0.02, 1e-3

#: Of a joint that stands still, what stays unexplained is worth a word from this share of its
#: effort on, and from this share of the largest joint's.
SHARE_OF_OWN, SHARE_OF_LARGEST = 0.1, 0.005


def stribeck_velocity(samples: SampleBlocks, causes: Causes) -> float:
    """Return the speed of the Stribeck effect that explains most beside other causes [rad/s]."""
    weight = causes.weight

    def columns(torques: list[np.ndarray]) -> np.ndarray:
        x = (np.concatenate(torques, axis=-1) * weight[..., None]).reshape(weight.size, -1)
        size = np.linalg.norm(x, axis=0)
        return x / np.where(size > 0.0, size, 1.0)

    u, s, _ = np.linalg.svd(columns([*causes.units.values()]), full_matrices=False)
    others = u[:, s > 1e-10 * s[0]]
    y = (causes.torque * weight).ravel()
    y = y - others @ (others.T @ y)

    def left(logarithm: float) -> float:
        x = columns([stribeck_torque(samples, float(np.exp(logarithm)))])
        x = x - others @ (others.T @ x)
        return float(np.linalg.norm(y - x @ np.linalg.lstsq(x, y, rcond=1e-8)[0]))

    grid = np.log(np.geomspace(SLOWEST_DECAY, FASTEST_DECAY, 25))
    best = int(np.argmin([left(each) for each in grid]))
    return float(np.exp(_minimum(left, grid[max(best - 1, 0)], grid[min(best + 1, 24)])))


def _minimum(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one minimum is least, by golden section."""
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(40):
        span = ratio * (high - low)
        if function(high - span) < function(low + span):
            high = low + span
        else:
            low = high - span
    return 0.5 * (low + high)


def stiction_cause(
    samples: SampleBlocks, held: np.ndarray, level: np.ndarray,
) -> dict[str, Any] | None:
    """
    Return the cause where joints hold more at rest than they resist in motion.

    ``held`` (b, w, 6): torque that friction takes in each sample [N m]; ``level`` (b, w, 6): dry
    friction in slow motion [N m].
    """
    stands = sticking(samples)
    size = np.where(stands, np.abs(held), 0.0)
    excess = np.where(stands, size - level, 0.0).max(axis=(0, 1))
    largest = size.max(axis=(0, 1))
    found = (sliding(samples).any(axis=0) & (excess > STICTION_SHARE * largest)
             & (excess > LEAST_STICTION))
    if not found.any():
        return None
    joints = {JOINT_NAMES[i]: {'value': float(excess[i]), 'held': float(largest[i])}
              for i in np.flatnonzero(found)}
    listed = ', '.join(f'{name} {each["value"]:.4g} (holds {each["held"]:.4g})'
                       for name, each in joints.items())
    return {'kind': 'stiction', 'joints': joints, 'share': 1.0,
            'sentence': 'stiction: at rest joints hold more than they resist in motion [N m]: '
            f'{listed}; a smaller torque does not move them'}


def standing_joints(samples: SampleBlocks, fit: Fit, causes: Causes) -> dict[str, Any] | None:
    """
    Return the joints that stand still under a torque which what was found does not explain.

    There friction at rest, a load and an offset look alike, so that none of them is named.
    """
    if not fit.determined.all():
        return None  # the fit leaves them open
    torque = causes.torque.copy()
    for name in fit.names:
        torque -= causes.units[name] @ fit.value[fit.part(name, causes)]
    stands = ~sliding(samples)
    size = np.sqrt(np.sum(np.where(stands, torque, 0.0)**2, axis=0)
                   / np.maximum(stands.sum(axis=0), 1))
    effort = np.sqrt(np.mean(samples.effort**2, axis=(0, 1)))
    found = (stands.mean(axis=0) > 0.5) & ~is_noise(torque) & (size > SHARE_OF_OWN * effort) & (
        size > SHARE_OF_LARGEST * effort.max())
    if not found.any():
        return None
    joints = {JOINT_NAMES[i]: {'value': float(size[i])} for i in np.flatnonzero(found)}
    listed = ', '.join(f'{name} {each["value"]:.3g}' for name, each in joints.items())
    return {'kind': 'unexplained', 'share': 0.0, 'joints': joints,
            'sentence': 'joints that stand still, under a torque that is not explained [N m RMS]: '
            f'{listed}; friction at rest, a load and an offset look alike there, so move them'}
