"""Did joints and tool follow the reference once the transient was over?"""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.laws import (
    BEYOND_THEORY,
    Law,
    largest,
    laws_of,
    promised_rows,
)
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.analysis.tracking import ToolTracking, tool_errors
from ur5_ros.config.validation import Marks
from ur5_ros.control.gains import error_poles
from ur5_ros.signals import JOINT_NAMES

#: Time constants of the slowest mode after which the transient counts as over.
SETTLED_TIME_CONSTANTS = 9.0

#: A step of the reference beyond its speed that starts a new transient [rad].
REFERENCE_JUMP = 1e-3

NAMES = ('tool position', 'tool orientation', 'joint tracking')


def tracking_checks(
    run: Run, marks: Marks, tool: ToolTracking, predicted: np.ndarray,
) -> list[Check]:
    """
    Return the checks of tool and joints against the reference.

    ``predicted`` is the error of the sampled loop by theory, shape (n, 6) [rad], NaN where it is
    not known.

    """
    laws, star = laws_of(run), run.required_reference
    promised = promised_rows(laws, len(run.stamp))
    error = run.exact.q - star.q
    known = np.isfinite(error).all(axis=1)
    if not known.any():
        return [not_applicable(name, 'no state has a reference') for name in NAMES]
    if not promised.any():
        return _without_verdict(run, tool, error[known], laws[0].parameters.get('mode'))
    settled = known & promised & (_since_jump(run, known, laws) >= _transient(laws, len(known)))
    begin = float(run.t[np.argmax(settled)]) if settled.any() else float(
        _transient(laws, len(known)).max())
    period = run.h * 1e3
    rows = np.flatnonzero(settled & np.isfinite(predicted).all(axis=1))
    theory = tool_errors(star.q[rows] + predicted[rows], star.q[rows],
                         run.required_control.arm)
    checks = []
    for name, series, expected, mark, unit, scale, shown in (
            ('tool position', tool.distance, theory[0], 'settled_position', 'm', 1e3, 'mm'),
            ('tool orientation', tool.angle, theory[1], 'settled_orientation', 'rad', 1e3,
             'mrad')):
        limit = max(marks[mark] * period, BEYOND_THEORY * expected.max(initial=0.0))
        greatest, rms = float(np.nanmax(series)), float(np.sqrt(np.nanmean(series**2)))
        numbers = {'max': greatest, 'rms': rms,
                   'settled_after_s': _settling(run.t, series, limit)}
        if not settled.any():
            checks.append(not_applicable(
                name, 'the run ends before its transient does '
                f'({SETTLED_TIME_CONSTANTS:g} time constants: {begin:.3g} s); '
                f'largest error {greatest * scale:.3g} {shown}', **numbers))
            continue
        worst = float(series[settled].max())
        checks.append(judge(
            name, worst, limit, unit,
            f'at most {worst * scale:.3g} {shown} after {begin:.3g} s '
            f'(RMS of the whole run {rms * scale:.3g} {shown}, largest '
            f'{greatest * scale:.3g} {shown})', **numbers))
    limit = max(marks['settled_joint'] * period,
                BEYOND_THEORY * np.abs(predicted[rows]).max(initial=0.0))
    checks.append(_joint_tracking(error[known], error[settled], begin, limit))
    return checks


def _without_verdict(run: Run, tool: ToolTracking, error, mode) -> list[Check]:
    """Return the tracking without a verdict, for a law that has no linear error equation."""
    why = f'the law (mode {mode}) promises no error equation'
    words = []
    for series, scale, unit in ((tool.distance, 1e3, 'mm'), (tool.angle, 1e3, 'mrad')):
        rms = np.sqrt(np.nanmean(series**2))
        words.append(f'RMS {rms * scale:.3g} {unit}, largest {np.nanmax(series) * scale:.3g} '
                     f'{unit}')
    rms = np.sqrt(np.mean(error**2, axis=0))
    words.append(f'RMS {rms.max() * 1e3:.3g} mrad at {JOINT_NAMES[int(np.argmax(rms))]}')
    return [not_applicable(name, f'{why}; {word}')
            for name, word in zip(NAMES, words, strict=True)]


def _transient(laws: list[Law], count: int) -> np.ndarray:
    """Return how long the transient of each row's law lasts [s], shape (count,)."""
    duration = np.full(count, np.inf)
    for law in laws:
        slowest = -float(error_poles(law.gains).real.max())
        duration[law.first:law.end] = SETTLED_TIME_CONSTANTS / slowest
    return duration


def _since_jump(run: Run, known: np.ndarray, laws: list[Law]) -> np.ndarray:
    """Return the time since reference or law began, or were last changed [s], shape (n,)."""
    star, h = run.required_reference, run.h
    jump = np.abs(star.q[1:] - star.q[:-1] - 0.5 * h * (star.qd[1:] + star.qd[:-1])).max(axis=1)
    new = np.concatenate([[True], (jump > REFERENCE_JUMP) | (known[1:] & ~known[:-1])])
    new[[law.first for law in laws]] = True
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
