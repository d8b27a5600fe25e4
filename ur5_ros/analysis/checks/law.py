"""The law computed again from its recorded inputs: states and references."""

from collections.abc import Sequence

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.laws import Law, largest, laws_of, promised_rows
from ur5_ros.analysis.residual import CHUNK
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.friction import friction_torque
from ur5_ros.signals import JOINT_NAMES


def law_torque(run: Run, laws: Sequence[Law], rows: np.ndarray) -> np.ndarray:
    """
    Return the computed torque of ascending rows before any limit, shape (n, 6) [N m].

    Kebria 2016, eq. (11): M a + C qd + g with a = qdd* - Kd(qd - qd*) - Kp(q - q*).

    """
    star, arm = run.required_reference, run.required_control.arm
    out = np.empty((len(rows), 6))
    for law in laws:
        begin, end = np.searchsorted(rows, (law.first, law.end))
        for start in range(begin, end, CHUNK):
            these = slice(start, min(start + CHUNK, end))
            some = rows[these]
            q, qd = run.states.q[some], run.states.qd[some]
            a = (star.qdd[some] - (qd - star.qd[some]) @ law.gains.kd.T
                 - (q - star.q[some]) @ law.gains.kp.T)
            out[these] = inverse_dynamics(q + arm.angle_offset, qd, a, arm)
            if law.parameters.get('friction_feedforward'):
                load = inverse_dynamics(q + arm.angle_offset, qd, np.zeros(q.shape), arm)
                out[these] += friction_torque(arm.friction, star.qd[some], load)
    return out


def law_check(run: Run, marks: Marks) -> Check:
    """Return whether the commands are the law's, with the gains in force and the bag's arm."""
    name = 'law'
    if run.control is None or run.reference is None or run.command is None:
        return not_applicable(name, 'commands, references or the law are not recorded')
    laws = [law for law in laws_of(run)
            if law.promised and not law.parameters.get('torque_rate_limit')]
    if not laws:
        return not_applicable(name, 'not plain computed torque: it is not computed again')
    known = run.has_reference & np.isfinite(run.command).all(axis=1)
    known &= promised_rows(laws, len(known))
    rows = np.flatnonzero(known)
    if not len(rows):
        return not_applicable(name, 'no state has a reference and an answer')
    torque, limit = law_torque(run, laws, rows), run.control.arm.limits.effort
    if run.control.parameters.get('effort_convention') == 'gravity_excluded':
        arm = run.control.arm
        torque -= gravity_torque(run.states.q[rows] + arm.angle_offset, arm)
    away = run.command[rows] - torque
    away[(np.abs(torque) >= limit).any(axis=1)] = np.nan
    worst, joint, row = largest(away)
    if worst < 0.0:
        return not_applicable(name, 'every command is at a torque limit')
    sentence = f'commands and the law computed again differ by at most {worst:.2g} N m'
    if not worst <= marks['command']:
        wrong = (np.abs(away) > marks['command']).any(axis=1)
        sentence = (f'{wrong.sum()} commands are not those of the law with the gains and the arm '
                    f'in the bag, the first at {run.t[rows[np.argmax(wrong)]]:.4g} s (worst: '
                    f'{worst:.3g} N m at {JOINT_NAMES[joint]}, {run.t[rows[row]]:.4g} s): another '
                    'law answered, or it was changed and the bag does not say so')
    return judge(name, worst, marks['command'], 'N m', sentence, joint=JOINT_NAMES[joint])
