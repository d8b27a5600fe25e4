"""Does the controller under test do its work, whatever its law: follow, settle, stay calm?"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5_ros.analysis.checks.tracking import REFERENCE_JUMP
from ur5_ros.analysis.data.run import NodeRecord, Run
from ur5_ros.analysis.laws import largest, laws_of, promised_rows
from ur5_ros.analysis.residual import rows_since
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.arms import ASSUMED, arms_with_assumed_armature
from ur5_ros.config.friction import joint_friction
from ur5_ros.config.validation import Marks
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.friction import AT_REST
from ur5_ros.signals import JOINT_NAMES

#: Length of the windows in which an alternating velocity is looked for [s].
WINDOW_TIME = 0.1

#: A joint slower than this at the end of a run rests [rad/s].
SLOW = 0.01

NOT_JUDGED = 'controller'


def controller_checks(run: Run, marks: Marks) -> list[Check]:
    """
    Return the checks of a controller that is not this package's computed torque.

    Computed torque is judged by its own error equation, a robot's log by its torques: there are no
    such checks then.

    """
    if run.follows_reference or _has_error_equation(run):
        return []
    if run.reference is None or not np.isfinite(run.reference.q).all(axis=1).any():
        return [not_applicable(NOT_JUDGED, 'no reference is recorded, so the controller is not '
                               'judged; give one: --reference TOPIC, EXPERIMENT, joints or pose'),
                _stability(run, marks)]
    if run.contact is not None and run.contact.any():
        why = 'the arm touched something, which keeps it from its reference'
        return [*(not_applicable(f'controller {what}', why) for what in (
            'tracking', 'settling', 'overshoot')), _torque(run, marks), _stability(run, marks)]
    known = np.isfinite(run.reference.q).all(axis=1)
    error = np.where(known[:, None], run.exact.q - run.reference.q, np.nan)
    starts = _starts(run, known)
    return [_tracking(run, marks, error, starts), _settling(run, marks, error, starts),
            _overshoot(run, marks, error, starts), _torque(run, marks), _stability(run, marks)]


def _has_error_equation(run: Run) -> bool:
    if run.control is None or run.control.parameters.get('mode') == 'unknown':
        return False
    return bool(promised_rows(laws_of(run), len(run.stamp)).any())


def _starts(run: Run, known: np.ndarray) -> np.ndarray:
    """Return the rows at which the reference begins or jumps."""
    star = run.required_reference
    ahead = 0.5 * run.h * (np.nan_to_num(star.qd[1:]) + np.nan_to_num(star.qd[:-1]))
    with np.errstate(invalid='ignore'):
        jump = np.abs(star.q[1:] - star.q[:-1] - ahead).max(axis=1) > REFERENCE_JUMP
    return np.flatnonzero(np.concatenate([[known[0]], known[1:] & (jump | ~known[:-1])]))


def _tracking(run: Run, marks: Marks, error: np.ndarray, starts: np.ndarray) -> Check:
    """Return the largest joint error once the time to settle is over."""
    name, wait = 'controller tracking', marks['controller_settling']
    last = starts[np.maximum(np.searchsorted(starts, np.arange(len(error)), side='right') - 1, 0)]
    late = run.t - run.t[last] >= wait
    rms = np.sqrt(np.nanmean(error**2, axis=0))
    details = {'rms_by_joint': dict(zip(JOINT_NAMES, rms.tolist(), strict=True))}
    rows = late & np.isfinite(error).all(axis=1)
    if not rows.any():
        return not_applicable(name, f'the reference never stays for {wait:g} s without a jump; '
                              f'RMS error {1e3 * rms.max():.3g} mrad', **details)
    worst, joint, row = largest(np.where(rows[:, None], error, np.nan))
    return judge(name, worst, marks['controller_joint'], 'rad',
                 f'joints within {1e3 * worst:.3g} mrad of the reference, {wait:g} s after it '
                 f'began or jumped (worst: {JOINT_NAMES[joint]} at {run.t[row]:.4g} s; RMS of the '
                 f'run {1e3 * rms.max():.3g} mrad){_at_rest(run, error[-1], marks)}',
                 joint=JOINT_NAMES[joint], **details)


def _at_rest(run: Run, error: np.ndarray, marks: Marks) -> str:
    """Return in words what keeps joints beside their reference at the end of a run."""
    if run.sim is None or rows_since(run, 'fallback', True)[-1]:
        return ''
    speed, beside = np.abs(run.exact.qd[-1]), np.abs(error) > marks['controller_joint']
    if not joint_friction(run.sim.parameters).none:
        held = _names(beside & (speed < AT_REST))
        return f'; at the end friction holds {held} beside the reference' if held else ''
    resting = _names(beside & (speed < SLOW))
    if not resting or run.sim.parameters['effort_convention'] != 'total':
        return ''
    return (f'; at the end {resting} rest beside it: a law without a gravity term holds gravity '
            'by its error, with effort_convention gravity_excluded the robot holds it')


def _names(joints: np.ndarray) -> str:
    return ', '.join(JOINT_NAMES[i] for i in np.flatnonzero(joints))


def _segments(error: np.ndarray, starts: np.ndarray, band: float) -> list[np.ndarray]:
    """Return the errors after each step that is larger than the band."""
    parts = np.split(error, starts)[1:]
    return [part for part in parts if len(part) > 1 and np.abs(part[0]).max() > band]


def _settling(run: Run, marks: Marks, error: np.ndarray, starts: np.ndarray) -> Check:
    """Return the longest time that a step takes to stay within the band."""
    name, band = 'controller settling', marks['controller_joint']
    times, open_for = [], 0.0
    for part in _segments(error, starts, band):
        outside = np.flatnonzero(~(np.abs(part) <= band).all(axis=1))
        settled = outside[-1] + 1 < len(part)
        times.append((outside[-1] + 1) * run.h if settled else np.inf)
        open_for = max(open_for, 0.0 if settled else len(part) * run.h)
    if not times:
        return not_applicable(name, 'no step of the reference: the arm starts on it')
    worst = max(times)
    words = (f'the error stays below {1e3 * band:g} mrad after {worst:.3g} s' if np.isfinite(worst)
             else f'not settled within {open_for:.3g} s, when the run or the step ends: the error '
             f'is above {1e3 * band:g} mrad')
    return judge(name, worst, marks['controller_settling'], 's', words, steps=len(times))


def _overshoot(run: Run, marks: Marks, error: np.ndarray, starts: np.ndarray) -> Check:
    """Return the largest excursion beyond the reference, as a share of the step."""
    name, band = 'controller overshoot', marks['controller_joint']
    worst, joint = -1.0, 0
    for part in _segments(error, starts, band):
        for i in np.flatnonzero(np.abs(part[0]) > band):
            share = float(np.nanmax(-part[:, i] / part[0, i], initial=0.0))
            if share > worst:
                worst, joint = share, int(i)
    if worst < 0.0:
        return not_applicable(name, 'no step of the reference: the arm starts on it')
    return judge(name, worst, marks['controller_overshoot'], '1',
                 f'joints overshoot the reference by at most {worst:.0%} of a step (worst: '
                 f'{JOINT_NAMES[joint]})', joint=JOINT_NAMES[joint])


def _torque(run: Run, marks: Marks) -> Check:
    """Return how much of the time the controller asks for all the torque that there is."""
    name, record, effort = 'controller torque', run.law_record, run.exact.effort[1:]
    known = np.isfinite(effort).all(axis=1)
    if record is None or not known.any():
        return not_applicable(name, 'no torques or no arm are recorded')
    use = np.abs(effort[known]) / record.arm.limits.effort
    share = float((use >= 1.0 - 1e-9).any(axis=1).mean())
    most, joint, _ = largest(use)
    rms = np.sqrt(np.mean(effort[known]**2, axis=0))
    return judge(name, share, marks['controller_saturated'], '1',
                 f'at most {most:.0%} of a torque limit ({JOINT_NAMES[joint]}); a limit is '
                 f'reached in {share:.1%} of the periods',
                 rms_by_joint=dict(zip(JOINT_NAMES, rms.tolist(), strict=True)))


def _stability(run: Run, marks: Marks) -> Check:
    """Return whether velocities alternate from period to period: a loop unstable when sampled."""
    name = 'controller stability'
    if run.sim is None:
        return not_applicable(name, 'measured velocities of a robot carry noise')
    size = alternation(run)
    if not len(size):
        return not_applicable(name, 'the run is too short')
    worst, joint, row = largest(size)
    at = row * max(2, round(WINDOW_TIME * run.control_rate)) * run.h
    words = 'no joint velocity alternates from period to period'
    if worst > marks['controller_alternation']:
        words = (f'{JOINT_NAMES[joint]} alternates from period to period from {at:.3g} s on: the '
                 'loop is unstable when sampled')
    return judge(name, worst, marks['controller_alternation'], 'rad/s',
                 f'{words} (largest RMS over {WINDOW_TIME:g} s: {worst:.2g} rad/s)',
                 joint=JOINT_NAMES[joint])


def alternation(run: Run) -> np.ndarray:
    """Return the alternating part of the joint velocities, RMS by window, shape (m, 6) [rad/s]."""
    qd, window = run.exact.qd, max(2, round(WINDOW_TIME * run.control_rate))
    part = 0.5 * (qd[1:-1] - 0.5 * (qd[2:] + qd[:-2]))
    opposite = np.maximum(-part[1:] * part[:-1], 0.0)  # a slow oscillation keeps its sign
    count = len(opposite) // window
    return np.sqrt(np.mean(opposite[:count * window].reshape(count, window, 6), axis=1))


def sampled_cause(run: Run, checks: Sequence[Check]) -> dict[str, Any] | None:
    """Return the cause of an unstable loop: the damping that a held torque cannot carry."""
    failed = next((check for check in checks if check.name == 'controller stability'
                   and check.verdict == 'fail'), None)
    if failed is None:
        return None
    joint, record = failed.details['joint'], run.sim or run.control
    words = f'{joint} is unstable when sampled at {run.control_rate:g} Hz'
    cause = {'kind': 'unstable when sampled', 'joint': joint}
    if record is None:
        return cause | {'sentence': f'{words}; lower its damping or raise the control rate'}
    arm, i = record.arm, JOINT_NAMES.index(joint)
    inertia = inertia_matrix(run.exact.q[0] + arm.angle_offset, arm)
    most = run.control_rate / float(np.linalg.inv(inertia)[i, i])
    return cause | {'largest_damping': most, 'sentence': (
        f'{words}: a torque held for a period carries a damping of about {most:.2g} N m s/rad on '
        f'this joint of {record.arm_name}, beside the inertia that it moves; lower its damping, '
        f'raise control_rate{_other_arm(record)}')}


def _other_arm(record: NodeRecord) -> str:
    """Return the advice to take an arm with rotor inertia, where this one has none."""
    better = {'ur5': 'ur5_real'}.get(record.arm_name, record.arm_name + ASSUMED)
    known = better == 'ur5_real' or better in arms_with_assumed_armature()
    return f', or simulate the arm with rotor inertia: {better}' if known else ''
