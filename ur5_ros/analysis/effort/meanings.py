"""What a recorded effort means: hypotheses with figures, and the one that holds."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.current import MOTOR_CURRENT, are_factors_of_drives
from ur5_ros.analysis.effort.fit import (
    CLEARLY_BETTER,
    deciding_joints,
    fit_current,
    misfit_of,
    relative_size,
    torque_of,
    unexplained,
)
from ur5_ros.analysis.residual_blocks import SampleBlocks, sample_blocks
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters

#: At rest a torque without gravity is compared with this share of gravity.
GRAVITY_SHARE = 0.02

#: What factors of any size leave, as a share of how much the torque varies, what joint torque must
#: leave for them to be the meaning, and the logarithm of a factor that is joint torque itself.
SURE, FAR, NEAR_ONE = 0.1, 0.3, 0.2

#: Relative spread below which an effort is constant, and above which the motion is not at rest.
CONSTANT, VARYING = 1e-3, 0.02

#: Meaning -> what it is, in words.
MEANINGS = {
    'total': 'joint torque',
    'gravity_excluded': 'joint torque without gravity',
    'target': "gravity alone, a controller's target torque for a reference at rest",
    'current': MOTOR_CURRENT,
    'other_sign': 'joint torque with the other sign',
    'constant': 'constant, not a measurement',
    'exchanged': 'joint torque of other joints',
}


class Hypothesis(NamedTuple):
    """One meaning of the effort and how well it fits."""

    meaning: str
    """``total``, ``gravity_excluded``, ``target``, ``current``, ``other_sign``, ``constant``,
    ``exchanged``."""
    misfit: float
    """Effort left unexplained, RMS relative to each joint's effort."""
    factors: tuple[float, ...] = ()
    """Torque of a unit of effort [N m/A] per joint, for ``current``; NaN where unknown."""
    load: float = 0.0
    """Mass at the tool with which it fits so [kg]."""
    joints: tuple[int, ...] = ()
    """The joints that it holds for, of ``constant`` and of another sign; empty for all."""
    varies: float = 0.0
    """How much the torque varies, of ``current``: standard deviation as a share of the RMS, of
    the joint where it is least."""
    turned: bool = False
    """Whether it is with the other sign, of ``gravity_excluded`` and ``target``."""
    shifted: float = np.inf
    """The misfit where each joint may have a constant besides, of ``total``."""
    whole: bool = False
    """Whether positions and velocities are exchanged too, of ``exchanged``."""

    @property
    def words(self) -> str:
        """The meaning in words."""
        return MEANINGS[self.meaning] + (', with the other sign' if self.turned else '')


def effort_hypotheses(run: Run, arm: ArmParameters) -> list[Hypothesis]:
    """
    Return the meanings that the effort can have, best first; empty where it is not recorded.

    Friction, viscous and Coulomb, is fitted to each joint beside every meaning.

    """
    samples = sample_blocks(run, arm)
    if samples is None:
        return []
    actual = samples
    if run.follows_reference:  # a reference at rest: the arm may move all the same
        actual = sample_blocks(replace(run, follows_reference=False), arm) or samples
    effort = samples.effort.mean(axis=1)
    torque = torque_of(samples, arm)
    gravity = gravity_torque(samples.q, arm).mean(axis=1)
    least = GRAVITY_SHARE * float(np.sqrt(np.mean(gravity**2, axis=0)).max())
    standing = gravity_torque(actual.q, arm).mean(axis=1)
    of_actual = actual.effort.mean(axis=1)
    found = [Hypothesis('total', misfit_of(effort, torque, samples), shifted=relative_size(
                 unexplained(effort, torque, samples, constant=True), effort)),
             Hypothesis('gravity_excluded', misfit_of(effort, torque - gravity, samples, least)),
             Hypothesis('target', misfit_of(of_actual, standing, actual)),
             _current(effort, torque, samples),
             *_turned('other_sign', effort, torque, samples),
             *_turned('gravity_excluded', effort, torque - gravity, samples, least),
             *_turned('target', of_actual, standing, actual)]
    if _is_constant(effort) and not _is_constant(torque, VARYING):
        found.append(Hypothesis('constant', 0.0))
    return sorted(found, key=lambda each: each.misfit)


def best_meaning(found: Sequence[Hypothesis], limit: float) -> Hypothesis:
    """Return the meaning that holds: joint torque unless another one is clearly better."""
    total = joint_torque_of(found)
    if total.misfit <= 0.5 * limit:
        return total
    for each in found:
        better = each.misfit <= min(limit, CLEARLY_BETTER * total.misfit,
                                    total.shifted / CLEARLY_BETTER)
        if each.meaning == 'constant' or (better and each.meaning != 'current'):
            return each
        if better and (are_factors_of_drives(each.factors) or _is_sure(each, total)):
            return each
    return total


def joint_torque_of(found: Sequence[Hypothesis]) -> Hypothesis:
    """Return the hypothesis that the effort is joint torque."""
    return next(each for each in found if each.meaning == 'total')


def _turned(meaning: str, effort: np.ndarray, torque: np.ndarray, samples: SampleBlocks,
            least: float = 0.0) -> list[Hypothesis]:
    """Return a meaning with the other sign: at every joint, and at those that look so."""
    named = meaning != 'other_sign'
    found = [Hypothesis(meaning, misfit_of(-effort, torque, samples, least), turned=named)]
    times, _ = fit_current(effort, torque, samples)
    against = np.where(np.isnan(times), np.sum(effort * torque, axis=0), times) < 0.0
    joints = np.flatnonzero(against)
    if 0 < len(joints) < 6:
        sign = np.where(np.isin(np.arange(6), joints), -1.0, 1.0)
        found.append(Hypothesis(meaning, misfit_of(sign * effort, torque, samples, least),
                                joints=tuple(joints.tolist()), turned=named))
    return found


def _current(effort: np.ndarray, torque: np.ndarray, samples: SampleBlocks) -> Hypothesis:
    """Return motor current: a factor a joint, friction beside it."""
    factors, model = fit_current(effort, torque, samples)
    size = np.sqrt(np.mean(torque**2, axis=0))
    varies = (np.std(torque, axis=0) / np.maximum(size, 1e-12))[deciding_joints(effort)]
    return Hypothesis('current', relative_size(effort - model, effort), tuple(factors.tolist()),
                      varies=float(varies.min()))


def _is_sure(found: Hypothesis, total: Hypothesis) -> bool:
    """Return whether a factor a joint, of any size but one, explains what no torque would do."""
    factors = np.array([each for each in found.factors if np.isfinite(each)])
    other = len(factors) > 0 and factors.min() > 0.0 and abs(np.log(np.median(factors))) > NEAR_ONE
    return bool(other and found.misfit < SURE * found.varies and total.misfit > FAR)


def _is_constant(values: np.ndarray, share: float = CONSTANT) -> bool:
    spread, size = np.std(values, axis=0).max(), np.abs(values).max()
    return bool(spread <= share * size)
