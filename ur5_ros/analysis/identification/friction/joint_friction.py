"""A family of friction as the friction of an arm file: parts that the simulator knows."""

from collections.abc import Sequence

import numpy as np

from ur5_ros.analysis.identification.friction.families import (
    FEATURES,
    LINEAR,
    STRIBECK,
    STRIBECK_SPEEDS,
    Family,
)
from ur5_ros.model.friction import JointFriction

#: Largest asymmetry that is looked for, and steps of the search.
MOST_ASYMMETRIC, STEPS = 0.9, 40

#: Columns of the fit -> part of :class:`JointFriction`.
_PARTS = ('viscous', 'coulomb', 'viscous_cubic', 'load_factor', 'static')
_ASYMMETRIC = {FEATURES.index(name) for name in ('asymmetric', 'asymmetric viscous')}
_CUBIC, _LOAD = (FEATURES.index(name) for name in ('viscous cubic', 'load-dependent'))


def joint_friction_of(families: Sequence[Family | None], features: np.ndarray,
                      torque: np.ndarray, known: np.ndarray,
                      linear: tuple[np.ndarray, np.ndarray] | None = None) -> JointFriction:
    """
    Return friction with the parts of each joint's family that explains a torque best.

    Every part resists the motion, as the model has it: least squares, parts that would drive a
    joint on left out, the asymmetry by a search.

    Parameters
    ----------
    families : sequence of Family or None
        Of each joint; None and a family without features for no friction.
    features : numpy.ndarray, shape (n, 6, 12)
        Of friction.
    torque : numpy.ndarray, shape (n, 6)
        What friction took, that of the temperature left out [N m].
    known : numpy.ndarray, shape (n, 6)
        Where it is known.
    linear : tuple of numpy.ndarray, optional
        Viscous and Coulomb friction, (6,) each, of the joints whose family is these two alone.

    """
    parts = {name: np.zeros(6) for name in (*_PARTS, 'asymmetry')}
    parts['stribeck_velocity'] = np.full(6, 0.05)
    for joint, family in enumerate(families):
        if family is None or not family.features:
            continue
        if linear is not None and family.features == tuple(range(LINEAR)):
            for name, value in zip(('viscous', 'coulomb'), linear, strict=True):
                parts[name][joint] = max(float(np.nan_to_num(value[joint])), 0.0)
            continue
        use = known[:, joint] & np.isfinite(torque[:, joint])
        x, y = features[use, joint], torque[use, joint]
        asymmetry = _asymmetry(family, x, y) if _ASYMMETRIC & {*family.features} else 0.0
        found = _fit(_columns(family, x, asymmetry), y)
        for name, each in zip(_PARTS, found, strict=True):
            parts[name][joint] = each
        parts['asymmetry'][joint] = asymmetry
        speed = _stribeck(family)
        if speed and found[4] > 0.0:
            parts['static'][joint] = found[1] + found[4]
            parts['stribeck_velocity'][joint] = speed
    return JointFriction(**parts)


def _stribeck(family: Family) -> float:
    """Return the Stribeck speed of a family [rad/s]; 0 for none."""
    return next((speed for i, speed in enumerate(STRIBECK_SPEEDS)
                 if STRIBECK + i in family.features), 0.0)


def _columns(family: Family, x: np.ndarray, asymmetry: float) -> np.ndarray:
    """Return the torque of a unit of each part, shape (n, 5); zero for those it does not have."""
    speed = _stribeck(family)
    decay = x[:, STRIBECK + STRIBECK_SPEEDS.index(speed)] if speed else np.zeros(len(x))
    symmetric = np.column_stack([
        x[:, 0], x[:, 1], x[:, _CUBIC] * (_CUBIC in family.features),
        x[:, _LOAD] * (_LOAD in family.features), decay])
    one_sided = np.abs(symmetric)
    one_sided[:, 1] = 1.0
    return symmetric + asymmetry * one_sided


def _fit(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return least squares with every part but the cubic one at least zero, shape (5,)."""
    use = np.any(x != 0.0, axis=0)
    value = np.zeros(x.shape[1])
    for _ in range(x.shape[1]):
        value[:] = 0.0
        value[use] = np.linalg.lstsq(x[:, use], y, rcond=None)[0]
        below = use & (value < 0.0) & (np.arange(len(value)) != _PARTS.index('viscous_cubic'))
        if not below.any():
            break
        use[int(np.argmin(np.where(below, value, 0.0)))] = False
    return value


def _asymmetry(family: Family, x: np.ndarray, y: np.ndarray) -> float:
    """Return the asymmetry with which the parts explain most, by golden section."""
    def left(asymmetry: float) -> float:
        columns = _columns(family, x, asymmetry)
        return float(np.sum((y - columns @ _fit(columns, y))**2))

    grid = np.linspace(-MOST_ASYMMETRIC, MOST_ASYMMETRIC, STEPS + 1)
    best = int(np.argmin([left(each) for each in grid]))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, STEPS)]
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(STEPS // 2):
        span = ratio * (high - low)
        low, high = ((low, low + span) if left(high - span) < left(low + span)
                     else (high - span, high))
    return float(0.5 * (low + high))
