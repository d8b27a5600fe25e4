"""Does the recorded error follow the error equation; tracking of joints and tool."""

from typing import Any

import numpy as np

from ur5_ros.analysis.checks.tracking import NAMES as TRACKING_NAMES
from ur5_ros.analysis.checks.tracking import tracking_checks
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.error_dynamics import ErrorDynamics, error_dynamics
from ur5_ros.analysis.laws import (
    BEYOND_THEORY,
    Law,
    largest,
    law_active,
    laws_of,
    noise_allowance,
    promised_rows,
)
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.analysis.tracking import tool_tracking
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import number_of

#: Largest correction Kp e + Kd d of the paper's experiment, at its start: the error of a sampled
#: transient grows with it [rad/s^2].
PAPER_CORRECTION = 1.5

_NAMES = ('error step', 'error recursion', 'error continuous')


def law_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """Return the checks of error equation and tracking, and the series for the figures."""
    if run.reference is None or run.control is None:
        why = ('no reference is recorded: the law is not judged' if run.reference is None else
               'the law is not recorded; see the checks of the controller')
        series = {'tool': tool_tracking(run, run.sim.arm, run.sim.arm)} if run.sim else {}
        return [not_applicable(name, why) for name in (*_NAMES, *TRACKING_NAMES)], series
    arm = run.sim.arm if run.sim else run.control.arm
    tool = tool_tracking(run, arm, run.control.arm)
    checks, dynamics = _error_checks(run, marks)
    checks += tracking_checks(run, marks, tool, dynamics.sampled)
    return checks, {'tool': tool, 'dynamics': dynamics}


def _error_checks(run: Run, marks: Marks) -> tuple[list[Check], ErrorDynamics]:
    laws = laws_of(run)
    promised = promised_rows(laws, len(run.stamp))[:-1]
    counted = law_active(run) & promised
    dynamics = error_dynamics(run, laws, counted)
    why = ''
    if not promised.any():
        why = f'mode {laws[0].parameters["mode"]}: no linear error equation is promised'
    elif not counted.any():
        why = 'there is no period in which the law was in charge'
    if why:
        return [not_applicable(name, why) for name in _NAMES], dynamics
    left_out = int((~counted).sum())
    note = f'; {number_of(left_out, "period")} left out' if left_out else ''
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
                f'{words} {1e3 * worst:.3g} mrad (worst: {JOINT_NAMES[joint]} at '
                f'{run.t[row]:.4g} s){note}', joint=JOINT_NAMES[joint]))
    else:
        why = ('the law sees noise: the equation does not hold sample by sample' if noise else
               f'{run.substeps} physics steps a control period: the torque is held, and the '
               'equation of one step is not exact' if run.substeps else
               "not this package's simulator: the plant's own time step is not known")
        checks = [not_applicable(name, why) for name in _NAMES[:2]]
    worst, joint, row = largest(dynamics.error - dynamics.continuous)
    predicted, _, _ = largest(dynamics.sampled - dynamics.continuous)
    allowed = marks['continuous' if run.substeps == 1 else 'continuous_held'] * run.h * 1e3
    correction = max(_correction(dynamics, law) for law in laws)
    limit = max(allowed, allowed * correction / PAPER_CORRECTION, BEYOND_THEORY * predicted)
    checks.append(judge(
        'error continuous', worst, limit + noise, 'rad',
        f"e(t) and the solution of e'' + Kd e' + Kp e = 0 differ by at most "
        f'{1e3 * worst:.3g} mrad (worst: {JOINT_NAMES[joint]} at {run.t[row]:.4g} s){note}',
        joint=JOINT_NAMES[joint]))
    return checks, dynamics


def _correction(dynamics: ErrorDynamics, law: Law) -> float:
    """Return the largest correction that the gains of a law make of its errors [rad/s^2]."""
    rows = slice(law.first, law.end)
    correction = dynamics.error[rows] @ law.gains.kp.T + dynamics.rate[rows] @ law.gains.kd.T
    return float(np.nanmax(np.abs(correction), initial=0.0)) if law.promised else 0.0
