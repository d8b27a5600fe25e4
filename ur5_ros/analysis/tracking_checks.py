"""Did joints and tool keep to the reference once the transient was over?"""

import numpy as np

from ur5_ros.analysis.law_promise import gains_of, largest, sampling_factor
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.analysis.series import Run
from ur5_ros.analysis.tracking import ToolTracking
from ur5_ros.config.validation import Marks
from ur5_ros.control.gains import error_poles
from ur5_ros.signals import JOINT_NAMES

#: Time constants of the slowest mode after which the transient counts as over.
SETTLED = 9.0

#: A step of the reference beyond its speed that starts a new transient [rad].
JUMP = 1e-3

NAMES = ('tool position', 'tool orientation', 'joint tracking')


def tracking_checks(run: Run, marks: Marks, tool: ToolTracking) -> list[Check]:
    """
    Return the checks of tool and joints against the reference.

    Parameters
    ----------
    run : Run
        A recording with a reference.
    marks : Marks
        Pass marks.
    tool : ToolTracking
        Poses and errors of the tool.

    """
    rate = -float(error_poles(gains_of(run)).real.max())
    error = run.exact.q - run.reference.q
    known = np.isfinite(error).all(axis=1)
    if not known.any():
        return [not_applicable(name, 'no state has a reference') for name in NAMES]
    if run.control.parameters.get('mode') != 'computed_torque':
        return _tracking_told(run, tool, error[known])
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
    limit = marks['settled_held_angle' if held else 'settled_joint'] * factor
    checks.append(_joint_tracking(error[known], error[settled], begin, limit))
    return checks


def _tracking_told(run: Run, tool: ToolTracking, error) -> list[Check]:
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
            for name, word in zip(NAMES, words, strict=True)]


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


def _settling(t: np.ndarray, series: np.ndarray, limit: float) -> float | None:
    """Return the time after which the series stays below the limit, None if it never does."""
    above = np.flatnonzero(~(series <= limit) & np.isfinite(series))
    if not above.size:
        return 0.0
    return float(t[above[-1] + 1]) if above[-1] + 1 < len(t) else None
