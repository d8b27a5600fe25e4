"""Do model and plant agree: the residual with both arms, and is the command what acted?"""

from typing import Any

import numpy as np

from ur5_ros.analysis.checks.foreign import inverse_dynamics_check
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.diagnosis.command_path import path_causes
from ur5_ros.analysis.laws import largest
from ur5_ros.analysis.plant_integrator import law_model, plant_models
from ur5_ros.analysis.residual import command_defect, residual, rows_since
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES

#: What joint i moves.
LINKS = ('shoulder', 'upper arm', 'forearm', 'wrist 1', 'wrist 2', 'wrist 3')

#: No arm of the family has a gravity torque that changes faster with an angle [N m/rad].
STEEPEST_GRAVITY = 1000.0

_NAMES = ('residual, controller arm', 'residual, simulator arm')


def model_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """Return the residual checks and the residuals for the figures."""
    if run.sim is None or not run.substeps or run.noisy:
        why = ('states are measured ones, without the exact ones beside them' if run.sim else
               "not a bag of this package's simulator: its time step is not known")
        smooth, series = inverse_dynamics_check(run, marks)
        return [*(not_applicable(name, f'{why}; see inverse dynamics') for name in _NAMES),
                smooth, _command_check(run, marks)], series
    checks, series = [], {}
    if run.control is None:
        checks.append(not_applicable(_NAMES[0], "the controller's arm is not recorded"))
    else:
        found = residual(run, [(0, law_model(run, run.control.arm))])
        series['residual_control'] = found.torque
        checks.append(_residual_check(
            _NAMES[0], found.torque, run, marks, f'the law ({run.control.arm_name})'))
    found = residual(run, plant_models(run))
    series['residual_sim'] = found.torque
    checks.append(_residual_check(
        _NAMES[1], found.torque, run, marks,
        f'the equations ({run.sim.arm_name}, with all that was added to the plant)'))
    checks.append(_command_check(run, marks))
    return checks, series


def localize_fault(over: np.ndarray) -> str:
    """
    Return in words which joints are beyond the mark (bool, shape (6,)), and the link they show.

    The torque of joint i depends on link i and those beyond it alone, so a wrong link leaves the
    joints beyond it clean.

    """
    names = [name for name, bad in zip(JOINT_NAMES, over, strict=True) if bad]
    if not names:
        return 'no joint is beyond the limit: a compared value is not a number'
    outermost = int(np.flatnonzero(over)[-1])
    if outermost == 5:
        return f'{len(names)} joints are beyond the limit, the outermost is {names[-1]}'
    beyond = ', as the joints beyond it agree'
    return (f'joints beyond the limit: {", ".join(names)}; the outermost is {names[-1]}, so '
            f'check the {LINKS[outermost]}{beyond}')


def _residual_check(name: str, torque: np.ndarray, run: Run, marks: Marks, part: str) -> Check:
    known = np.isfinite(torque).all(axis=1)
    if not known.any():
        return not_applicable(name, 'no state is followed by the one a period later')
    worst, joint, row = largest(torque)
    size = np.abs(torque[known])
    per_joint = {joint_name: {'max': float(size[:, i].max()),
                              'rms': float(np.sqrt(np.mean(size[:, i]**2)))}
                 for i, joint_name in enumerate(JOINT_NAMES)}
    sentence = (f'plant and {part} agree within {worst:.3g} N m over {known.sum()} periods '
                f'(worst: {JOINT_NAMES[joint]})')
    if not worst <= marks['residual']:
        over = size.max(axis=0) > marks['residual']
        sentence = (f'plant and {part} differ by {worst:.3g} N m at {JOINT_NAMES[joint]}, '
                    f'{run.t[row]:.4g} s; {localize_fault(over)}')
    if run.truth is not None:
        sentence += '; from the exact states, which are recorded beside the measured ones'
    return judge(name, worst, marks['residual'], 'N m', sentence, joint=JOINT_NAMES[joint],
                 joints=per_joint, periods=int(known.sum()))


def _command_check(run: Run, marks: Marks) -> Check:
    name = 'command acts'
    if run.command is None:
        return not_applicable(name, 'no stamped commands are recorded')
    defect = command_defect(run)
    known = np.isfinite(defect).all(axis=1)
    if not known.any():
        return not_applicable(name, 'no state with an answer is followed by another state')
    worst, joint, row = largest(defect)
    limit = marks['command']
    if run.noisy and run.sim and run.sim.parameters['effort_convention'] == 'gravity_excluded':
        noise = run.sim.parameters['noise.position']
        limit += STEEPEST_GRAVITY * 6.0 * noise  # g(q) of a measured q
    differs = known & (np.abs(np.where(known[:, None], defect, 0.0)).max(axis=1) > limit)
    wrong = int(differs.sum())
    if run.sim is None and wrong and (run.counts.get('commands_held') or not path_causes(run)):
        return not_applicable(
            name, f'a robot measures its torque: it differs from the command by up to {worst:.3g} '
            f'N m at {JOINT_NAMES[joint]}')
    sentence = (f'the torque that acted is the command within {worst:.2g} N m' if worst > 0.0 else
                'the torque that acted is the command, to the last bit')
    if not worst <= limit:
        sentence = (f'in {wrong} of {known.sum()} periods another torque acted than was '
                    f'commanded; worst {worst:.3g} N m at {JOINT_NAMES[joint]}, '
                    f'{run.t[row]:.4g} s{_fallback(run, differs)}')
    return judge(name, worst, limit, 'N m', sentence, joint=JOINT_NAMES[joint],
                 periods=int(known.sum()), differing=wrong)


def _fallback(run: Run, differs: np.ndarray) -> str:
    """Return in words in how many of some periods the fallback acted, and what began it."""
    acted = rows_since(run, 'fallback', True) & differs
    if run.sim is None or not acted.any():
        return ''
    first = int(np.argmax(acted))
    before = [event for event in run.events if event.stamp <= run.stamp[first]]
    mode = [event.values['mode'] for event in before if event.kind == 'fallback'][-1]
    stop = any(event.kind == 'protective_stop' for event in before)
    return (f'; in {acted.sum()} of them that of the fallback ({mode}), from '
            f'{run.t[first]:.4g} s on{", after a protective stop" if stop else ""}')
