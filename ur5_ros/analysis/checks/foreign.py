"""Checks of recordings that are not of this package's simulator: kinematics, effort, torque."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort import (
    CLEARLY_BETTER,
    FACTOR_SPREAD,
    LARGEST_DRIVE,
    LARGEST_MISFIT,
    LEAST_FACTOR,
    MEANINGS,
    MOST_OF_MILLI,
    Hypothesis,
    best_meaning,
    drive_factors,
    effort_hypotheses,
    fitting_arms,
    has_geometry_of,
    known_arms,
)
from ur5_ros.analysis.effort_with_load import unlikely_meaning
from ur5_ros.analysis.residual_blocks import BLOCK_TIME, sample_blocks
from ur5_ros.analysis.result import FAIL, PASS, Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES

#: Motion that counts as rest, RMS over a block [rad], and the share of the largest one below which
#: a joint's own motion does not set its scale.
AT_REST, LITTLE_MOTION = 1e-3, 0.1

#: Change of a velocity between two states, as a share of it, from which on the states are too few,
#: at rates below the second [Hz].
COARSE, SLOW_RATE = 1.0, 20.0

#: Positions and velocities that differ by less than this many times their noise are the same.
NOISES = 3.0

#: Share of the mark, and of another misfit, above which a meaning is looked for further.
UNSURE_SHARE = 0.3

#: Share of an effort left unexplained from which on an arm explains nothing of it.
NOTHING_EXPLAINED = 1.0

#: Another arm that leaves at most this many times what motor current leaves is the likelier one.
AS_GOOD = 1.2

NO_TORQUE = 'no torque is recorded'


def kinematics_check(run: Run, marks: Marks) -> Check:
    """Return whether positions change by the integral of the velocities, over blocks of 0.1 s."""
    name, size = 'kinematics', max(1, round(BLOCK_TIME * run.control_rate))
    if any('differentiated' in remark for remark in run.remarks):
        return not_applicable(name, 'no velocity is measured')
    q, qd, t = run.states.q, run.states.qd, run.t
    whole = run.steps
    step = np.where(whole[:, None], np.diff(q, axis=0), 0.0)
    integral = np.where(whole[:, None], 0.5 * (qd[1:] + qd[:-1]) * np.diff(t)[:, None], 0.0)
    edges = np.arange(0, len(step), size)
    step, integral = (np.add.reduceat(part, edges) for part in (step, integral))
    motion = np.sqrt(np.mean(step**2, axis=0))
    moving = motion > AT_REST
    if not moving.any():
        still = np.sqrt(np.mean(integral**2, axis=0))
        return judge(name, float(still.max()), 10.0 * AT_REST, 'rad',
                     'the arm is at rest, in position and in velocity')
    error = np.sqrt(np.mean((step - integral)**2, axis=0))
    if sentence := _too_coarse(run):
        return not_applicable(name, sentence)
    error = np.where(error > NOISES * _noise(run, size), error, 0.0)
    share = error / np.maximum(motion, LITTLE_MOTION * motion.max())
    joint = int(np.argmax(share))
    return judge(name, share[joint], marks['kinematics'], '1',
                 f'positions and integrated velocities differ by {share[joint]:.2%} of the motion '
                 f'(worst: {JOINT_NAMES[joint]}){_in_degrees(step, integral)}',
                 joint=JOINT_NAMES[joint])


def _noise(run: Run, size: int) -> np.ndarray:
    """Return what noise makes of a position less an integrated velocity over a block, (6,)."""
    position, velocity = (np.sqrt(np.mean(np.diff(each, 2, axis=0)**2, axis=0) / 6.0)
                          if len(each) > 2 else np.zeros(6)
                          for each in (run.states.q, run.states.qd))
    noise: np.ndarray = np.hypot(np.sqrt(2.0) * position, np.sqrt(size) * run.h * velocity)
    return noise


def _too_coarse(run: Run) -> str:
    """Return why a motion cannot be judged of which states are missing between states, or ''."""
    step = np.diff(run.states.qd, axis=0)[run.steps]
    if run.follows_reference or run.control_rate >= SLOW_RATE or not len(step):
        return ''
    change, speed = (np.sqrt(np.mean(each**2, axis=0)) for each in (step, run.states.qd))
    joint = int(np.argmax(speed))
    if change[joint] < COARSE * speed[joint] or speed[joint] * run.h < AT_REST:
        return ''
    return (f'{run.control_rate:.3g} states a second are too few for this motion: the velocity of '
            f'{JOINT_NAMES[joint]} turns between two of them; record more')


def _in_degrees(step: np.ndarray, integral: np.ndarray) -> str:
    """Return in words where velocities are 57.3 times what the positions show."""
    times = float(np.sum(step * integral) / max(float(np.sum(step**2)), 1e-300))
    return '; the velocities look like degrees a second' if abs(
        times - np.degrees(1.0)) < 0.05 * np.degrees(1.0) else ''


def effort_check(run: Run, marks: Marks) -> Check:
    """Return what the recorded effort is; fails where it is not joint torque and not stated."""
    name, record = 'effort', run.law_record
    if record is None:
        return not_applicable(name, 'no arm is known; give one: --arm NAME')
    if run.effort_meaning != 'total':
        return Check(name, PASS, f'taken as {MEANINGS[run.effort_meaning]}, as stated by --effort')
    if np.isnan(run.states.effort).all():
        return not_applicable(name, NO_TORQUE)
    if sentence := _too_coarse(run):
        return not_applicable(name, sentence)
    found = effort_hypotheses(run, record.arm)
    if not found:
        return not_applicable(name, 'too few states with a torque follow each other')
    details: dict[str, Any] = {'misfits': {each.meaning: each.misfit for each in found}}
    best, total = best_meaning(found, marks['effort']), _total(found)
    if best.misfit > UNSURE_SHARE * marks['effort']:
        other = unlikely_meaning(run, record.arm, marks['effort'])
        better = other is not None and other.misfit < UNSURE_SHARE * best.misfit and (
            total.misfit > marks['effort']) and CLEARLY_BETTER * other.misfit < total.shifted
        if other is not None and better and (
                other.meaning != 'constant' or best.meaning == 'total'):
            best = other
    if best.meaning == 'total' or _another_arm_fits(run, best):
        return Check(name, PASS, f'joint torque: {total.misfit:.2%} of it stays unexplained '
                     'beside friction', total.misfit, unit='1', details=details)
    details['factors'] = list(best.factors)
    return Check(name, FAIL, _sentence(best, total), best.misfit, unit='1',
                 details={**details, 'meaning': best.meaning})


def no_torque_of_arm(run: Run, effort: Check) -> str:
    """
    Return why an effort is no torque of the arm of its run; empty where it may be.

    ``effort``: what :func:`effort_check` returned.  An arm may be heavier or lighter than its
    file; that less than nothing is explained, or another known arm of another geometry fits, it
    cannot be.
    """
    record, left = run.law_record, effort.value
    if record is None or left is None or effort.verdict != PASS or left < LARGEST_MISFIT:
        return ''
    fits = [fit for fit in fitting_arms(run)
            if fit.misfit < min(LARGEST_MISFIT, 0.5 * left)
            and not has_geometry_of(record.arm, fit.name)]
    if left < NOTHING_EXPLAINED and (not fits or record.arm_name not in known_arms()):
        return ''
    way_out = (f'{fits[0].name} fits, with {fits[0].misfit:.2%}: give --arm {fits[0].name}' if fits
               else 'none of the known arms fits; give the arm that it is of, or record the joint '
               'torque')
    return (f'the effort is no torque of arm {record.arm_name}: {left:.0%} of it stays '
            f'unexplained; {way_out}')


def _total(found: list[Hypothesis]) -> Hypothesis:
    return next(each for each in found if each.meaning == 'total')


def _another_arm_fits(run: Run, best: Hypothesis) -> bool:
    """Return whether the effort is joint torque of another known arm, and that fits better."""
    fits = fitting_arms(run)
    share = AS_GOOD if best.meaning == 'current' else 0.5  # which has a factor a joint to fit with
    return bool(fits) and min(fit.misfit for fit in fits) < share * best.misfit


def _words_of_factors(factors: Sequence[float]) -> tuple[str, str]:
    """Return what an effort with these factors looks like, and the factors in words."""
    known = np.array([each for each in factors if np.isfinite(each)])
    if not len(known):
        return MEANINGS['current'], 'no factors'
    middle = float(np.median(known))
    if len(known) > 2 and np.ptp(known) < FACTOR_SPREAD * abs(middle):
        return 'joint torque in another unit', f'{middle:.4g} N m a unit at every joint'
    if abs(middle) > LARGEST_DRIVE or MOST_OF_MILLI < abs(middle) < LEAST_FACTOR:
        return ('joint torque in another unit', 'joints 1 to 6: ' + ', '.join(
            '-' if np.isnan(each) else f'{each:.4g}' for each in factors) + ' N m a unit')
    milli = abs(middle) < MOST_OF_MILLI
    listed = ', '.join('-' if np.isnan(each) else f'{each * (1e3 if milli else 1.0):.4g}'
                       for each in factors)
    looks = MEANINGS['current'] + (' in mA' if milli else '') + (
        ' with the other sign' if middle < 0.0 else '')
    return looks, f'factors of joints 1 to 6: {listed} N m/A'


def _sentence(best: Hypothesis, total: Hypothesis) -> str:
    figures = f'{best.misfit:.2%} stays unexplained, as joint torque {total.misfit:.2%}'
    which = ', '.join(JOINT_NAMES[i] for i in best.joints)
    if best.meaning == 'constant':
        of = f' of {which}' if which else ''
        return f'the effort{of} is {MEANINGS["constant"]}, so torques cannot be judged'
    if best.meaning == 'exchanged':
        of = 'positions, velocities and efforts' if best.whole else 'efforts'
        how = 'in the other order' if len(best.joints) == 6 else f'exchanged: {which}'
        return (f'the {of} are those of other joints, {how} ({figures}); name the joints in the '
                'order of their values')
    looks = best.words + (f' at {which}' if which else '')
    if best.meaning == 'current':
        looks, factors = _words_of_factors(best.factors)
        figures = f'{factors}, {figures}'
    if best.load:
        figures = f'with a load of {best.load:.3g} kg at the tool {figures}'
    return (f'the effort looks like {looks} ({figures}), and if it is, give '
            f'--effort {best.meaning}')


def inverse_dynamics_check(run: Run, marks: Marks) -> tuple[Check, dict[str, Any]]:
    """Return the check of the inverse dynamics smoothed over blocks, for any recording."""
    name, record = 'inverse dynamics', run.law_record
    if record is None:
        return not_applicable(name, 'no arm is known; give one: --arm NAME'), {}
    if run.sim is None and (sentence := _too_coarse(run)):
        return not_applicable(name, sentence), {}
    if run.effort_meaning == 'current':
        return _current_check(run, marks), {}
    if np.isnan(run.exact.effort).all():
        return not_applicable(name, NO_TORQUE), {}
    samples = sample_blocks(run, record.arm)
    if samples is None:
        return not_applicable(name, 'too few states with a torque follow each other'), {}
    unexplained_torque = samples.unexplained_torque.mean(axis=1)
    rms = np.sqrt(np.mean(unexplained_torque**2, axis=0))
    scale = float(np.sqrt(np.mean(samples.effort**2, axis=(0, 1))).max())
    joint = int(np.argmax(rms))
    length = samples.q.shape[1] * run.h
    check = judge(
        name, rms[joint] / scale if scale else np.nan, marks['residual_external'], '1',
        f'smoothed over {length:.3g} s, arm {record.arm_name} leaves {rms[joint]:.3g} N m RMS '
        f'unexplained at {JOINT_NAMES[joint]}, of torques up to '
        f'{np.abs(samples.effort).max():.3g} N m',
        joint=JOINT_NAMES[joint], rms_by_joint=dict(zip(JOINT_NAMES, rms.tolist(), strict=True)))
    return check, {'smoothed': (samples.time.mean(axis=1), unexplained_torque)}


def _current_check(run: Run, marks: Marks) -> Check:
    """Return whether motor currents are the torque of the arm by one factor a joint."""
    name, record = 'inverse dynamics', run.law_record
    found = drive_factors(run, record.arm) if record is not None else None
    if found is None:
        return not_applicable(name, 'too few states with a current follow each other')
    factors, current, model = found
    rms = np.sqrt(np.mean((current - model)**2, axis=0))
    scale = np.sqrt(np.mean(current**2, axis=0)).max()
    joint = int(np.argmax(rms))
    looks, shown = _words_of_factors(factors.tolist())
    return judge(name, rms[joint] / scale if scale else np.nan, marks['residual_external'], '1',
                 f'{looks}, {shown}, friction fitted: {rms[joint] / scale:.2%} of the largest '
                 f"joint's stays unexplained at {JOINT_NAMES[joint]}"
                 if scale else 'no current flows',
                 joint=JOINT_NAMES[joint], factors=factors.tolist())
