"""Did the law keep its promise: error dynamics, tracking of joints and tool."""

from typing import Any

import numpy as np

from ur5_ros.analysis.error_dynamics import ErrorDynamics, error_dynamics
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.analysis.series import Run
from ur5_ros.analysis.tracking import ToolTracking, tool_tracking
from ur5_ros.config.validation import Marks
from ur5_ros.control.gains import Gains, error_poles, gains_from
from ur5_ros.signals import JOINT_NAMES

#: Time constants of the slowest mode after which the transient counts as over.
SETTLED = 9.0

#: A step of the reference beyond its speed that starts a new transient [rad].
JUMP = 1e-3

#: Largest reference acceleration of the profile that the marks were measured on [rad/s^2].
PAPER_ACCELERATION = 0.56

_NAMES = ('error step', 'error recursion', 'error continuous')


def law_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """
    Return the checks of law and tracking, and the series for the figures.

    Parameters
    ----------
    run : Run
        The recording.
    marks : Marks
        Pass marks.

    """
    if run.reference is None or run.control is None:
        why = 'no reference is recorded: the law is not judged'
        names = (*_NAMES, 'tool position', 'tool orientation', 'joint tracking')
        return [not_applicable(name, why) for name in names], {}
    arm = run.sim.arm if run.sim else run.control.arm
    tool = tool_tracking(run, arm, run.control.arm)
    checks, dynamics = _error_checks(run, marks)
    return checks + _tracking_checks(run, marks, tool), {'tool': tool, 'dynamics': dynamics}


def law_in_charge(run: Run) -> np.ndarray:
    """
    Tell in which periods the law's command acted as it was given, shape (n - 1,).

    Not where a state went unanswered, across a gap, beyond the torque limits, or, when not in
    lockstep, where the command came too late.

    """
    star = np.isfinite(np.hstack([*run.reference])).all(axis=1)
    counted = run.steps & star[:-1] & star[1:]
    if run.command is None:
        return counted
    counted = counted & np.isfinite(run.command[:-1]).all(axis=1)
    if run.sim is None:
        return counted
    effort = run.exact.effort[1:]
    counted &= (np.abs(effort) < run.sim.arm.limits.effort).all(axis=1)
    if not run.sim.parameters['lockstep'] and (
            run.sim.parameters['effort_convention'] == 'total'):
        counted &= (np.abs(effort - run.command[:-1]) <= 1e-9).all(axis=1)
    return counted


def _error_checks(run: Run, marks: Marks) -> tuple[list[Check], ErrorDynamics]:
    parameters = run.control.parameters
    gains = gains_of(run)
    promised = parameters.get('mode', 'computed_torque') == 'computed_torque'
    counted = law_in_charge(run) & promised
    dynamics = error_dynamics(run, gains.kp, gains.kd, counted)
    why = ''
    if not promised:
        why = f'mode {parameters["mode"]}: no linear error equation is promised'
    elif not counted.any():
        why = 'there is no period in which the law was in charge'
    if why:
        return [not_applicable(name, why) for name in _NAMES], dynamics
    left_out = int((~counted).sum())
    note = f'; {left_out} periods left out' if left_out else ''
    checks = []
    noise = noise_allowance(run)
    if run.substeps == 1 and not noise:
        for name, mark, defect in (
                ('error step', 'step', dynamics.step[:, :6]),
                ('error recursion', 'recursion', dynamics.error - dynamics.sampled)):
            worst, joint, row = largest(defect)
            words = ('over one period e(t) and the sampled error equation differ by at most'
                     if mark == 'step' else 'followed from the first state, they differ by')
            checks.append(judge(
                name, worst, marks[mark], 'rad',
                f'{words} {worst:.2g} rad (worst: {JOINT_NAMES[joint]} at '
                f'{run.t[row]:.4g} s){note}', joint=JOINT_NAMES[joint]))
    else:
        why = ('the law sees noise: the equation does not hold sample by sample' if noise else
               f'{run.substeps} physics steps a control period: the torque is held, and the '
               'equation of one step is not exact' if run.substeps else
               "not this package's simulator: the plant's own time step is not known")
        checks = [not_applicable(name, why) for name in _NAMES[:2]]
    worst, joint, row = largest(dynamics.error - dynamics.continuous)
    mark = 'continuous' if run.substeps == 1 else 'continuous_held'
    checks.append(judge(
        'error continuous', worst, marks[mark] * sampling_factor(run) + noise, 'rad',
        f"e(t) and the solution of e'' + Kd e' + Kp e = 0 differ by at most {worst:.2g} rad "
        f'(worst: {JOINT_NAMES[joint]} at {run.t[row]:.4g} s){note}', joint=JOINT_NAMES[joint]))
    return checks, dynamics


def noise_allowance(run: Run) -> float:
    """
    Return by how much encoder noise may move e(t) [rad]; zero without noise.

    The law filters the noise: ten standard deviations of the position and ten of the velocity
    over a second bound what is left of it.

    """
    if run.sim is None:
        return 0.0
    given = run.sim.parameters
    return 10.0 * (given['noise.position'] + given['noise.velocity'] * 1.0)


def _tracking_checks(run: Run, marks: Marks, tool: ToolTracking) -> list[Check]:
    rate = -float(error_poles(gains_of(run)).real.max())
    error = run.exact.q - run.reference.q
    known = np.isfinite(error).all(axis=1)
    names = ('tool position', 'tool orientation', 'joint tracking')
    if not known.any():
        return [not_applicable(name, 'no state has a reference') for name in names]
    if run.control.parameters.get('mode') != 'computed_torque':
        return _tracking_told(run, tool, error[known], names)
    settled = known & (_since_jump(run, known) >= SETTLED / rate)
    begin = float(run.t[np.argmax(settled)]) if settled.any() else SETTLED / rate
    factor, held = sampling_factor(run), run.substeps != 1
    checks = []
    for name, series, mark, unit, scale, shown in (
            ('tool position', tool.distance,
             'settled_held_position' if held else 'settled_position', 'm', 1e3, 'mm'),
            ('tool orientation', tool.angle,
             'settled_held_angle' if held else 'settled_orientation', 'rad', 1e3, 'mrad')):
        numbers = {'max': float(np.nanmax(series)),
                   'rms': float(np.sqrt(np.nanmean(series**2))),
                   'settled_after_s': _settling(run.t, series, marks[mark] * factor)}
        if not settled.any():
            checks.append(not_applicable(
                name, f'the run ends before its transient does ({SETTLED:g} time constants: '
                f'{begin:.3g} s); largest error {numbers["max"] * scale:.3g} {shown}', **numbers))
            continue
        worst = float(series[settled].max())
        checks.append(judge(
            name, worst, marks[mark] * factor, unit,
            f'at most {worst * scale:.3g} {shown} after {begin:.3g} s '
            f'(RMS of the whole run {numbers["rms"] * scale:.3g} {shown}, largest '
            f'{numbers["max"] * scale:.3g} {shown})', **numbers))
    mark = marks['settled_held_angle' if held else 'settled_joint'] * factor
    checks.append(_joint_tracking(error[known], error[settled], begin, mark))
    return checks


def _tracking_told(run: Run, tool: ToolTracking, error, names) -> list[Check]:
    """Return the tracking without a verdict, for a law that promises nothing."""
    why = f'the law (mode {run.control.parameters.get("mode")}) promises no error equation'
    words = []
    for series, scale, unit in ((tool.distance, 1e3, 'mm'), (tool.angle, 1e3, 'mrad')):
        rms = np.sqrt(np.nanmean(series**2))
        words.append(f'RMS {rms * scale:.3g} {unit}, largest {np.nanmax(series) * scale:.3g} '
                     f'{unit}')
    rms = np.sqrt(np.mean(error**2, axis=0))
    words.append(f'RMS {rms.max() * 1e3:.3g} mrad at {JOINT_NAMES[int(np.argmax(rms))]}')
    return [not_applicable(name, f'{why}; {word}')
            for name, word in zip(names, words, strict=True)]


def _since_jump(run: Run, known: np.ndarray) -> np.ndarray:
    """Return the time since the reference began or last jumped [s], shape (n,)."""
    star, h = run.reference, run.h
    jump = np.abs(star.q[1:] - star.q[:-1] - 0.5 * h * (star.qd[1:] + star.qd[:-1])).max(axis=1)
    new = np.concatenate([[True], (jump > JUMP) | (known[1:] & ~known[:-1])])
    starts = np.maximum.accumulate(np.where(new, np.arange(len(new)), 0))
    return run.t - run.t[starts]


def _joint_tracking(error, settled, begin, limit) -> Check:
    per_joint = {name: {'rms': float(np.sqrt(np.mean(error[:, i]**2))),
                        'max': float(np.abs(error[:, i]).max())}
                 for i, name in enumerate(JOINT_NAMES)}
    if not len(settled):
        return not_applicable('joint tracking', 'the run ends before its transient does',
                              joints=per_joint)
    worst, joint, _ = largest(settled)
    return judge('joint tracking', worst, limit, 'rad',
                 f'at most {worst * 1e3:.3g} mrad after {begin:.3g} s '
                 f'(worst: {JOINT_NAMES[joint]})', joints=per_joint, joint=JOINT_NAMES[joint])


def sampling_factor(run: Run) -> float:
    """
    Return by how much the marks of the continuous theory grow for this run.

    A reference that is sampled with period h acts on the error equation like Kd h/2 qdd*: the
    marks stand for 1 ms and the paper's profile, and grow with the period and with an
    acceleration beyond :data:`PAPER_ACCELERATION`, with half as much again as another profile
    spreads it over the joints in another way.

    """
    hardest = float(np.nanmax(np.abs(run.reference.qdd), initial=0.0))
    share = hardest / PAPER_ACCELERATION
    return run.h * 1e3 * (1.0 if share <= 1.01 else 1.5 * share)


def gains_of(run: Run) -> Gains:
    """
    Return the gains that the controller's bag names.

    Raises
    ------
    Refusal
        If they make no stable error equation.

    """
    return gains_from(run.control.parameters['kp'], run.control.parameters['kd'])


def largest(values: np.ndarray) -> tuple[float, int, int]:
    """
    Return the largest magnitude, its column and its row; NaN entries are not looked at.

    Parameters
    ----------
    values : numpy.ndarray, shape (n, m)
        Numbers; those that are NaN were not measured.

    """
    size = np.abs(values)
    size[np.isnan(size)] = -1.0
    row, column = np.unravel_index(int(np.argmax(size)), size.shape)
    return float(size[row, column]), int(column), int(row)


def _settling(t: np.ndarray, series: np.ndarray, limit: float) -> float | None:
    """Return the time after which the series stays below the limit, None if it never does."""
    above = np.flatnonzero(~(series <= limit) & np.isfinite(series))
    if not above.size:
        return 0.0
    return float(t[above[-1] + 1]) if above[-1] + 1 < len(t) else None
