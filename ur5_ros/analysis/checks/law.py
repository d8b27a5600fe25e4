"""The law computed again from its recorded inputs: states and references."""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.law_torque import law_torque
from ur5_ros.analysis.laws import largest, laws_of
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import agree, number_of


def law_check(run: Run, marks: Marks) -> Check:
    """Return whether the commands are the law's, with the gains in force and the bag's arm."""
    name = 'law'
    if run.control is None or run.reference is None or run.command is None:
        return not_applicable(name, 'commands, references or the law are not recorded')
    laws = [law for law in laws_of(run)
            if law.without_memory and not law.parameters.get('torque_rate_limit')]
    if not laws:
        return not_applicable(name, 'a law with a memory, or a law_file: it is not computed again')
    answered = np.zeros(len(run.stamp), dtype=bool)
    for law in laws:
        answered[law.first:law.end] = True
    rows = np.flatnonzero(answered & run.has_reference & np.isfinite(run.command).all(axis=1))
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
        count, first = int(wrong.sum()), run.t[rows[np.argmax(wrong)]]
        sentence = (f'{number_of(count, "command")} {agree(count, "differ")} from the law with '
                    f'the gains and the arm in the bag, the first at {first:.4g} s (worst: '
                    f'{worst:.3g} N m at {JOINT_NAMES[joint]}, {run.t[rows[row]]:.4g} s): another '
                    'law answered, or it was changed and the bag does not say so')
    return judge(name, worst, marks['command'], 'N m', sentence, joint=JOINT_NAMES[joint])
