"""The check of what a recorded effort is: joint torque of the arm of its run, or what else."""

from typing import Any

import numpy as np

from ur5_ros.analysis.checks.foreign import NO_TORQUE, too_coarse
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.current import words_of_factors
from ur5_ros.analysis.effort.fit import CLEARLY_BETTER
from ur5_ros.analysis.effort.known_arms import LARGEST_MISFIT, fitting_arms, has_geometry_of
from ur5_ros.analysis.effort.meanings import (
    MEANINGS,
    Hypothesis,
    best_meaning,
    effort_hypotheses,
    joint_torque_of,
)
from ur5_ros.analysis.effort.unlikely import unlikely_meaning
from ur5_ros.analysis.result import FAIL, PASS, Check, not_applicable
from ur5_ros.config import known_arms
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES

#: Share of the mark, and of another misfit, above which a meaning is looked for further.
UNSURE_SHARE = 0.3

#: Share of an effort left unexplained from which on an arm explains nothing of it.
NOTHING_EXPLAINED = 1.0

#: Another arm that leaves at most this many times what motor current leaves is the likelier one.
AS_GOOD = 1.2


def effort_check(run: Run, marks: Marks) -> Check:
    """Return what the recorded effort is; fails where it is not joint torque and not stated."""
    name, record = 'effort', run.law_record
    if record is None:
        return not_applicable(name, 'no arm is known; give one: --arm NAME')
    if run.effort_meaning != 'total':
        return Check(name, PASS, f'taken as {MEANINGS[run.effort_meaning]}, as stated by --effort')
    if np.isnan(run.states.effort).all():
        return not_applicable(name, NO_TORQUE)
    if sentence := too_coarse(run):
        return not_applicable(name, sentence)
    found = effort_hypotheses(run, record.arm)
    if not found:
        return not_applicable(name, 'too few states with a torque follow each other')
    details: dict[str, Any] = {'misfits': {each.meaning: each.misfit for each in found}}
    best, total = best_meaning(found, marks['effort']), joint_torque_of(found)
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


def _another_arm_fits(run: Run, best: Hypothesis) -> bool:
    """Return whether the effort is joint torque of another known arm, and that fits better."""
    fits = fitting_arms(run)
    share = AS_GOOD if best.meaning == 'current' else 0.5  # which has a factor a joint to fit with
    return bool(fits) and min(fit.misfit for fit in fits) < share * best.misfit


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
        looks, factors = words_of_factors(best.factors)
        figures = f'{factors}, {figures}'
    if best.load:
        figures = f'with a load of {best.load:.3g} kg at the tool {figures}'
    return (f'the effort looks like {looks} ({figures}), and if it is, give '
            f'--effort {best.meaning}')
