"""Checks that need no simulator: kinematics, and the inverse dynamics smoothed over blocks."""

from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.current import drive_factors, words_of_factors
from ur5_ros.analysis.residual_blocks import BLOCK_TIME, sample_blocks
from ur5_ros.analysis.result import Check, judge, not_applicable
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
    if sentence := too_coarse(run):
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


def too_coarse(run: Run) -> str:
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


def inverse_dynamics_check(run: Run, marks: Marks) -> tuple[Check, dict[str, Any]]:
    """Return the check of the inverse dynamics smoothed over blocks, for any recording."""
    name, record = 'inverse dynamics', run.law_record
    if record is None:
        return not_applicable(name, 'no arm is known; give one: --arm NAME'), {}
    if run.sim is None and (sentence := too_coarse(run)):
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
    looks, shown = words_of_factors(factors.tolist())
    return judge(name, rms[joint] / scale if scale else np.nan, marks['residual_external'], '1',
                 f'{looks}, {shown}, friction fitted: {rms[joint] / scale:.2%} of the largest '
                 f"joint's stays unexplained at {JOINT_NAMES[joint]}"
                 if scale else 'no current flows',
                 joint=JOINT_NAMES[joint], factors=factors.tolist())
