"""Causes in the plant: another arm, payload, friction, rotor inertia, gravity; fitted."""

from dataclasses import replace
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.diagnosis.candidates import at_mean_pose, candidates, rests_in_one_pose
from ur5_ros.analysis.diagnosis.friction import (
    FASTEST_DECAY,
    SLOWEST_DECAY,
    standing_joints,
    stiction_cause,
    stribeck_velocity,
)
from ur5_ros.analysis.diagnosis.gravity import (
    GRAVITY_PASSES,
    gravity_with_load,
    is_gravity_possible,
    load_under,
)
from ur5_ros.analysis.diagnosis.link_body import link_torque
from ur5_ros.analysis.diagnosis.other_arm import arm_cause, best_arm, best_arm_with_friction
from ur5_ros.analysis.diagnosis.selection import (
    LINKS,
    MOST,
    Causes,
    Fit,
    choose,
    with_confounders,
)
from ur5_ros.analysis.diagnosis.sentences import sentences_of, unexplained
from ur5_ros.analysis.residual_blocks import (
    SLOW_MEASURED,
    SampleBlocks,
    load_torque,
    sample_blocks,
    sliding,
    stribeck_torque,
    velocity_noise,
)
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor
from ur5_ros.signals import JOINT_NAMES

#: A cause must explain this share of the unexplained torque, squared; more where the plant's time
#: step is not that of the recording, or there is noise.
SHARE_EXACT, SHARE_MEASURED = 1e-6, 1e-3

#: What a true cause leaves at most in exact samples.
ROUNDING = 1e-12

#: Block means below this are rounding [N m].
LEAST_TORQUE = 1e-9

#: A decay of friction is seen from this many times the slowest speed, or its noise, on.
SEEN = 4.0

#: Where causes leave so many times more than one must explain, an arm with friction beside it
#: counts that leaves less than this share of that.
WELL, MUCH_BETTER = 2.0, 0.2

#: Kinds of friction that are the same torque as long as a joint turns one way.
ONE_WAY_FRICTION = ('Coulomb friction', 'load-dependent friction', 'Stribeck friction')

#: What a cause says that is not found from what a real robot would have recorded.
EXACT_NOTE = 'from the exact states, which are recorded beside the measured ones'

#: What the only cause of an arm at rest may leave of the torque.
LEFT_AT_REST = 0.05

STRIBECK = 'Stribeck friction'


def plant_causes(run: Run, arm: ArmParameters) -> list[dict[str, Any]]:
    """
    Return what in the plant the controller's arm does not have; see :func:`_causes`.

    Where exact states are recorded beside noisy ones the causes are of those, and say so.

    """
    found = _causes(run, arm)
    if run.truth is not None and replace(run, truth=None).noisy:
        found = [{**cause, 'states': 'exact', 'sentence': f'{cause["sentence"]}; {EXACT_NOTE}'}
                 for cause in found]
    return found


def _causes(run: Run, arm: ArmParameters) -> list[dict[str, Any]]:
    """
    Return what in the plant the controller's arm does not have, most important first.

    Each has ``kind``, ``sentence``, ``share`` of the squared residual that is explained, and
    sizes with errors.  Another known arm is named before several fitted causes.

    """
    samples = sample_blocks(run, arm)
    if samples is None or not np.abs(samples.unexplained_torque).max() > 0.0:
        return []
    rests = not samples.exact and rests_in_one_pose(samples)
    if rests:
        samples = at_mean_pose(samples, arm)
    causes = candidates(samples, arm, run.effort_meaning == 'gravity_excluded', rests,
                        run.sim is None)
    least = SHARE_EXACT if samples.exact else SHARE_MEASURED
    other, left, *_ = best_arm(samples, arm, causes.weight)
    fit, causes, velocity = _choose(samples, causes, least)
    for _ in range(GRAVITY_PASSES):
        if 'gravity' not in fit.names or 'payload' not in causes.units:
            break
        causes = load_under(fit, causes, samples)
        fit, causes, velocity = _choose(samples, causes, least)
    together = gravity_with_load(causes, samples)
    if together is not None and together.left < MUCH_BETTER * fit.left:
        fit, causes, velocity = _choose(samples, together.causes, least)
    if run.sim is None and not is_gravity_possible(fit, causes):
        causes = causes._replace(units={name: unit for name, unit in causes.units.items()
                                        if name != 'gravity'})
        fit, causes, velocity = _choose(samples, causes, least)
    if not samples.exact and not rests:
        fit = with_confounders(fit, causes)
    # one cause alone does as well
    explained = len(fit.names) == 1 and fit.left < min(least, 2.0 * left)
    if other and not explained and (left < least or left < 0.1 and fit.left > ROUNDING and (
            left < 0.5 * fit.left or left < 1.05 * fit.left and len(fit.names) > 2)):
        return [arm_cause(other, arm, 1.0 - left, samples, causes.weight)]
    if not rests and (fit.left > WELL * least or len(fit.names) > 2):
        with_friction = best_arm_with_friction(samples, arm, causes, least)
        if with_friction.left < MUCH_BETTER * min(fit.left, 0.5) and with_friction.beside:
            return [arm_cause(with_friction.name, arm, 1.0 - with_friction.left, samples,
                              causes.weight),
                    *sentences_of(with_friction.beside, with_friction.causes or causes)]
    if rests and (len(fit.names) > 1 or fit.left > LEFT_AT_REST):
        return [unexplained(1.0, True)]
    found = sentences_of(fit, causes)
    if run.sim is None:
        found = [_with_option(_with_one_way(cause, samples)) for cause in found]
    if samples.measured and not rests and (standing := standing_joints(samples, fit, causes)):
        found = [*(cause for cause in found if fit.names), standing]
    for cause in found:
        if cause['kind'] == STRIBECK:
            cause |= {'velocity': velocity, 'sentence': f'{cause["sentence"]}; it has fallen to '
                      f'1/e at {velocity:.4g} rad/s'}
    if samples.exact and (stiction := _stiction(samples, fit, causes)):
        found = [*(cause for cause in found if cause['kind'] != 'unexplained'), stiction]
    return found


def _with_one_way(cause: dict[str, Any], samples: SampleBlocks) -> dict[str, Any]:
    """Return a cause of friction with the joints that never turn back: an offset looks like it."""
    if cause['kind'] not in ONE_WAY_FRICTION:
        return cause
    speed = np.where(sliding(samples), samples.qd.mean(axis=1), 0.0)
    back = np.logical_and((speed > 0.0).any(axis=0), (speed < 0.0).any(axis=0)).tolist()
    names = [name for name, turns in zip(JOINT_NAMES, back, strict=True)
             if name in cause['joints'] and not turns]
    if not names:
        return cause
    return {**cause, 'one_way': names,
            'sentence': f'{cause["sentence"]}; an offset or a load would look the same where the '
            f'motion is in one direction: {", ".join(names)}'}


def _with_option(cause: dict[str, Any]) -> dict[str, Any]:
    """Return a cause of gravity that an effort would show which leaves gravity out, with that."""
    if cause['kind'] != 'gravity missing':
        return cause
    return {**cause, 'sentence': f'{cause["sentence"]}, or the efforts leave it out: --effort '
            'gravity_excluded'}


def _choose(samples: SampleBlocks, causes: Causes, least: float) -> tuple[Fit, Causes, float]:
    """Return the causes chosen, with a Stribeck effect where the others leave something."""
    if not np.abs(causes.torque[causes.weight > 0.0]).max(initial=0.0) > LEAST_TORQUE:
        return Fit((), np.zeros(0), np.zeros(0), 0.0, np.zeros(0, dtype=bool)), causes, 0.0
    first = choose(causes, least)
    if first.left < (ROUNDING if samples.exact else least) or not sliding(samples).any():
        return first, causes, 0.0
    velocity = stribeck_velocity(samples, causes)
    more = causes._replace(
        units={**causes.units, STRIBECK: stribeck_torque(samples, velocity)})
    second = choose(more, least)
    slowest = 1.01 * SLOWEST_DECAY
    if samples.measured:  # where friction is seen at all
        slowest = max(slowest, SEEN * SLOW_MEASURED, SEEN * float(velocity_noise(samples).max()))
    gain = MOST if samples.measured else 0.0
    if STRIBECK in second.names and slowest < velocity < 0.99 * FASTEST_DECAY and (
            second.left < (1.0 - gain) * first.left):
        return second, more, velocity
    return first, causes, 0.0


def _stiction(samples: SampleBlocks, fit: Fit, causes: Causes) -> dict[str, Any] | None:
    """Return the cause where joints hold more at rest than the fitted friction resists."""
    held, level = samples.unexplained_torque.copy(), np.zeros(samples.qd.shape)
    for name in fit.names:
        value = fit.value[fit.part(name, causes)]
        if name == 'payload':
            held -= dynamics_regressor(
                samples.q, samples.qd, samples.qdd, causes.arm)[..., 50:] @ value
        elif name == 'gravity':
            held -= gravity_torque(samples.q, replace(causes.arm, gravity=value))
        elif name in LINKS:
            held -= link_torque(name, value, samples, causes.arm)
        elif name == 'armature':
            held -= value * samples.qdd
        elif name == 'viscous friction':
            held -= value * samples.qd_next
        elif name == 'load-dependent friction':
            level += value * np.abs(load_torque(samples, causes.arm))
        else:
            level += value
    return stiction_cause(samples, held, level)
