"""Fit of base parameters and friction to windows of torque, and the physical arm nearest to it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.identification.base_parameters import (
    BaseParameters,
    all_parameters,
    typical_sizes,
)
from ur5_ros.analysis.identification.friction.families import (
    FEATURES,
    LINEAR,
    Family,
    choose_family,
    folds_of,
)
from ur5_ros.analysis.identification.inertia import physical
from ur5_ros.analysis.identification.least_squares import Estimate, blocks_of, least_squares
from ur5_ros.analysis.identification.rows import Rows
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: Share of the base parameters that a motion must determine.
LEAST_DETERMINED = 0.5

#: Times that fit and families of friction are found in turn, and a residual that is rounding.
FAMILY_PASSES, ROUNDING = 3, 1e-8

#: Viscous and Coulomb friction of every joint, of which a fit begins.
_BOTH = [tuple(range(LINEAR))] * 6


class Fit(NamedTuple):
    """Base parameters, then parameters of friction."""

    estimate: Estimate
    friction: tuple[tuple[int, int], ...]
    """Joint and feature of each of the last columns."""

    @property
    def _first_of_friction(self) -> int:
        return len(self.estimate.value) - len(self.friction)

    @property
    def base(self) -> np.ndarray:
        """Return the base parameters, shape (b,)."""
        return self.estimate.value[:self._first_of_friction]

    @property
    def base_error(self) -> np.ndarray:
        """Return the standard errors of the base parameters, shape (b,)."""
        return self.estimate.error[:self._first_of_friction]

    def friction_torque(self, features: np.ndarray) -> np.ndarray:
        """Return the torque of friction [N m], (n, 6), from its features (n, 6, 12)."""
        torque = np.zeros(features.shape[:2])
        values = self.estimate.value[self._first_of_friction:]
        for (joint, feature), value in zip(self.friction, values, strict=True):
            torque[:, joint] += value * features[:, joint, feature]
        return torque

    def friction_terms(self) -> tuple[dict[str, tuple[float, float]], ...]:
        """Return feature -> value and standard error, joint by joint."""
        terms: tuple[dict[str, tuple[float, float]], ...] = tuple({} for _ in range(6))
        start = self._first_of_friction
        for (joint, feature), value, error in zip(
                self.friction, self.estimate.value[start:], self.estimate.error[start:],
                strict=True):
            terms[joint][FEATURES[feature]] = float(value), float(error)
        return terms


class Solution(NamedTuple):
    """The result of windows: the linear fit, the best one and the physical parameters."""

    linear: Fit
    """With viscous and Coulomb friction in every joint."""
    best: Fit
    """With the family of friction of each joint."""
    families: tuple[Family, ...]
    determined: np.ndarray
    """Which base parameters the motion determines, shape (b,)."""
    x: np.ndarray
    """Physical parameters, shape (66,)."""

    def linear_friction(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return viscous friction, its error, Coulomb friction and its error, (6,) each."""
        value, error = self.linear.estimate.value[-12:], self.linear.estimate.error[-12:]
        return value[:6], error[:6], value[6:], error[6:]


def solve(rows: Rows, base: BaseParameters, arm: ArmParameters) -> Solution:
    """
    Return fits, families of friction and the physical parameters of windows.

    InputError if a joint does not move, or the motion excites too few base parameters.

    """
    block = blocks_of(rows.time, rows.run)
    linear = fit_linear(rows, base)
    determined = _determined(linear.estimate, base, arm)
    best, families = linear, [Family(each, 0.0, 0.0, 0.0) for each in _BOTH]
    for _ in range(FAMILY_PASSES):
        chosen = families
        families = _families(rows, base, best, block)
        if [family.features for family in families] == [family.features for family in chosen]:
            break
        best = _fit(rows, base, [family.features for family in families], block)
    keep = np.flatnonzero(determined)
    x = physical(base.combination[keep], best.base[keep],
                 _information(best.estimate.factor, keep), all_parameters(arm),
                 typical_sizes(arm))
    return Solution(linear, best, tuple(families), determined, x)


def fit_linear(rows: Rows, base: BaseParameters) -> Fit:
    """Return base parameters, then viscous and Coulomb friction, before any physical arm."""
    return _fit(rows, base, _BOTH, blocks_of(rows.time, rows.run))


def _fit(rows: Rows, base: BaseParameters, chosen: Sequence[Sequence[int]],
         block: np.ndarray) -> Fit:
    """Fit the base parameters and, for each joint, the features of friction chosen for it."""
    # feature after feature, so that viscous friction of six joints comes first
    friction = tuple((joint, feature) for feature in range(len(FEATURES))
                     for joint in range(6) if feature in chosen[joint])
    columns = np.zeros((*rows.effort.shape, len(friction)))
    for place, (joint, feature) in enumerate(friction):
        columns[:, joint, place] = rows.friction[:, joint, feature]
    # The friction of a joint that sticks is whatever holds it: its torque is not known then.
    known = rows.sliding | np.array([not family for family in chosen])
    still = ~known.any(axis=0)
    if still.any():
        raise InputError(f'{JOINT_NAMES[int(np.argmax(still))]} does not move in these runs; '
                         'record one that moves every joint')
    x = np.concatenate([rows.inertial[..., base.columns], columns], axis=-1)
    return Fit(least_squares(x, rows.effort, known, block), friction)


def _determined(estimate: Estimate, base: BaseParameters, arm: ArmParameters) -> np.ndarray:
    """Return which base parameters the motion determines, better than to their typical size."""
    count = len(base.columns)
    typical = np.abs(base.combination) @ typical_sizes(arm)
    determined = estimate.determined[:count] & (estimate.error[:count] < typical)
    if determined.mean() < LEAST_DETERMINED:
        lost = [name for name, known in zip(base.names, determined, strict=True) if not known]
        raise InputError(
            f'these runs excite {determined.sum()} of {count} base parameters, too few to '
            f'distinguish the parameters; not excited: {", ".join(lost)}; record the experiment '
            'exciting, or one made by ur5 excite')
    return determined


def _families(rows: Rows, base: BaseParameters, fit: Fit, block: np.ndarray) -> list[Family]:
    """Return the family of friction of each joint, from what the rigid arm leaves."""
    left = rows.effort - rows.inertial[..., base.columns] @ fit.base
    wrong = left - fit.friction_torque(rows.friction)
    if np.abs(wrong[rows.sliding]).max(initial=0.0) < ROUNDING * np.abs(rows.effort).max():
        return [Family(each, 0.0, 0.0, 0.0) for each in _BOTH]
    families = []
    for i in range(6):
        use = rows.sliding[:, i]
        part = np.unique(block[use], return_inverse=True)[1]
        families.append(choose_family(rows.friction[use, i], np.zeros((use.sum(), 0)),
                                      left[use, i], folds_of(part)))
    return families


def _information(factor: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Return the square root of what is known of some parameters alone, (k, k)."""
    others = np.setdiff1d(np.arange(factor.shape[1]), keep)
    square = np.zeros((factor.shape[1],) * 2)
    triangle = np.asarray(np.linalg.qr(
        np.vstack([factor[:, [*others, *keep]], square]), mode='r'))
    return triangle[-len(keep):, -len(keep):]
