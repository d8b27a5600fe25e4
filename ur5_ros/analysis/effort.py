"""What a recorded effort means: hypotheses with figures, and the known arms that fit it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.residual_blocks import SampleBlocks, sample_blocks
from ur5_ros.config import list_arms, load_arm
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Another meaning must leave at most this share of what joint torque leaves.
CLEARLY_BETTER = 0.5

#: A factor between current and torque is at least this [N m/A].
LEAST_FACTOR = 2.0

#: A joint whose effort is below this share of the largest one does not decide, and what it leaves
#: weighs as if it were this share.
SMALL_SHARE, LEAST_SCALE = 0.02, 0.05

#: At rest a torque without gravity is compared with this share of gravity.
GRAVITY_SHARE = 0.02

#: Factors from current to torque that drives of the family can have [N m/A]: at most this much,
#: and in N m/mA.
LARGEST_DRIVE, MOST_OF_MILLI = 50.0, 0.05

#: What factors of any size leave, as a share of how much the torque varies, what joint torque must
#: leave for them to be the meaning, and the logarithm of a factor that is joint torque itself.
SURE, FAR, NEAR_ONE = 0.1, 0.3, 0.2

#: Spread of the factors under which the effort is torque in another unit.
FACTOR_SPREAD = 0.02

#: An arm that leaves more of the effort unexplained, as a share of it, does not fit.
LARGEST_MISFIT = 0.3

#: Lengths of two arms that differ by less are the same [m].
LENGTH_TOLERANCE = 1e-3

#: Relative spread below which an effort is constant, and above which the motion is not at rest.
CONSTANT, VARYING = 1e-3, 0.02

#: Meaning -> what it is, in words.
MEANINGS = {
    'total': 'joint torque',
    'gravity_excluded': 'joint torque without gravity',
    'target': "gravity alone, a controller's target torque for a reference at rest",
    'current': 'motor current',
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


class ArmFit(NamedTuple):
    """How well a known arm fits the recorded torques."""

    name: str
    rms: float
    """Torque left unexplained, RMS of the worst joint [N m]."""
    misfit: float
    """The same relative to each joint's effort."""


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
                 _left(effort, torque, samples, constant=True), effort)),
             Hypothesis('gravity_excluded', misfit_of(effort, torque - gravity, samples, least)),
             Hypothesis('target', misfit_of(of_actual, standing, actual)),
             _current(effort, torque, samples),
             *_turned('other_sign', effort, torque, samples),
             *_turned('gravity_excluded', effort, torque - gravity, samples, least),
             *_turned('target', of_actual, standing, actual)]
    if _is_constant(effort) and not _is_constant(torque, VARYING):
        found.append(Hypothesis('constant', 0.0))
    return sorted(found, key=lambda each: each.misfit)


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


def best_meaning(found: Sequence[Hypothesis], limit: float) -> Hypothesis:
    """Return the meaning that holds: joint torque unless another one is clearly better."""
    total = next(each for each in found if each.meaning == 'total')
    if total.misfit <= 0.5 * limit:
        return total
    for each in found:
        better = each.misfit <= min(limit, CLEARLY_BETTER * total.misfit,
                                    total.shifted / CLEARLY_BETTER)
        if each.meaning == 'constant' or (better and each.meaning != 'current'):
            return each
        if better and (is_plausible_current(each) or _is_sure(each, total)):
            return each
    return total


def fitting_arms(run: Run) -> list[ArmFit]:
    """Return the known arms by how well they fit the recorded torques, best first."""
    found = []
    for name, arm in known_arms().items():
        samples = sample_blocks(run, arm)
        if samples is None:
            return []
        effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
        left = _left(effort, torque, samples)
        found.append(ArmFit(name, float(np.sqrt(np.mean(left**2, axis=0)).max()),
                            misfit_of(effort, torque, samples)))
    return sorted(found, key=lambda fit: (fit.rms, fit.name))


def arms_by_meaning(run: Run) -> list[tuple[str, Hypothesis]]:
    """Return the known arms with the meaning of the effort that fits them, best first."""
    found = []
    for name, arm in known_arms().items():
        likely = [each for each in effort_hypotheses(run, arm)
                  if each.meaning not in ('total', 'constant')
                  and (each.meaning != 'current' or is_plausible_current(each))]
        found += [(name, likely[0])] if likely else []
    return sorted(found, key=lambda each: each[1].misfit)


@cache
def known_arms() -> dict[str, ArmParameters]:
    """Return the arms of config/arms, by name."""
    return {name: load_arm(name) for name in list_arms()}


def has_geometry_of(arm: ArmParameters, name: str) -> bool:
    """Return whether an arm has the lengths of a known one, signs of the angles aside."""
    other = known_arms()[name]
    return bool(np.abs(np.abs(arm.a) - np.abs(other.a)).max() < LENGTH_TOLERANCE
                and np.abs(np.abs(arm.d) - np.abs(other.d)).max() < LENGTH_TOLERANCE)


def drive_factors(
    run: Run, arm: ArmParameters,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """
    Return the torque of a unit of motor current per joint [N m/A], and effort and its model.

    The latter two are block means [A], shape (b, 6); None where too few states have a current.

    """
    if run.current is None:
        return None
    states = run.states._replace(effort=run.current)
    samples = sample_blocks(replace(run, states=states, truth=None, follows_reference=False), arm)
    if samples is None:
        return None
    effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
    factors, model = fit_current(effort, torque, samples)
    shifted = fit_current(effort, torque, samples, constant=True)
    if relative_size(effort - shifted[1], effort) < CLEARLY_BETTER * relative_size(
            effort - model, effort):
        factors, model = shifted
    return factors, effort, model


def torque_of(samples: SampleBlocks, arm: ArmParameters) -> np.ndarray:
    """Return the block means of the inverse dynamics of an arm, shape (b, 6)."""
    return inverse_dynamics(samples.q, samples.qd, samples.qdd, arm).mean(axis=1)


def friction_columns(samples: SampleBlocks) -> np.ndarray:
    """Return the block means of qd and sign(qd), shape (b, 6, 2); zero where a joint rests."""
    qd = samples.qd_next
    moving = np.where(np.abs(qd) > 1e-3, qd, 0.0)
    return np.stack([moving.mean(axis=1), np.sign(moving).mean(axis=1)], axis=-1)


def _left(effort: np.ndarray, torque: np.ndarray, samples: SampleBlocks,
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
    return relative_size(_left(effort, torque, samples), effort, least)


def fit_current(effort, torque, samples: SampleBlocks,
                constant: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the factor of each joint [N m/A] and the effort of the fit, shape (b, 6).

    ``constant``: whether a constant current may be added to each.
    """
    columns, factors, model = friction_columns(samples), np.full(6, np.nan), np.zeros_like(effort)
    large = _matters(effort)
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


def _matters(effort: np.ndarray) -> np.ndarray:
    """Return which joints have an effort that decides, shape (6,)."""
    scale = np.sqrt(np.mean(effort**2, axis=0))
    return scale > SMALL_SHARE * scale.max()


def _current(effort, torque, samples: SampleBlocks) -> Hypothesis:
    factors, model = fit_current(effort, torque, samples)
    size = np.sqrt(np.mean(torque**2, axis=0))
    varies = (np.std(torque, axis=0) / np.maximum(size, 1e-12))[_matters(effort)]
    return Hypothesis('current', relative_size(effort - model, effort), tuple(factors.tolist()),
                      varies=float(varies.min()))


def _is_sure(found: Hypothesis, total: Hypothesis) -> bool:
    """Return whether a factor a joint, of any size but one, explains what no torque would do."""
    factors = np.array([each for each in found.factors if np.isfinite(each)])
    other = len(factors) > 0 and factors.min() > 0.0 and abs(np.log(np.median(factors))) > NEAR_ONE
    return bool(other and found.misfit < SURE * found.varies and total.misfit > FAR)


def is_plausible_current(found: Hypothesis) -> bool:
    """Return whether every known factor has the same sign and one that a drive can have."""
    factors = np.array(found.factors)
    factors = factors[np.isfinite(factors)]
    if not len(factors) or not ((factors > 0.0).all() or (factors < 0.0).all()):
        return False
    middle = float(np.median(np.abs(factors)))
    alike = np.ptp(factors) < FACTOR_SPREAD * middle
    return middle > LEAST_FACTOR or middle < MOST_OF_MILLI or bool(alike and middle < 0.5)


def _is_constant(values: np.ndarray, share: float = CONSTANT) -> bool:
    spread, size = np.std(values, axis=0).max(), np.abs(values).max()
    return bool(spread <= share * size)
