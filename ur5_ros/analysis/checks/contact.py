"""Contact in a run: friction in its cone, passivity, the external torque."""

from typing import Any

import numpy as np

from ur5_ros.analysis.checks.contact_likely import contact_likely
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.momentum_observer import external_torque, first_order
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config import SIM_PARAMETERS
from ur5_ros.config.validation import Marks
from ur5_ros.model.kinematics import jacobian
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import number_of

_NAMES = ('Coulomb cone', 'contact passivity', 'external torque')

#: Gain of the momentum observer [1/s].
OBSERVER_GAIN = 50.0


def contact_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """Return the checks of contact and the series for the figures."""
    if run.contact is None:
        checks = [not_applicable(name, 'no contact torque is recorded: the run has no world')
                  for name in _NAMES]
        likely, series = contact_likely(run)
        return [*checks, *likely], series
    observer, series = _observer_check(run, marks)
    return [_cone_check(run, marks), _passivity_check(run, marks), observer], series


def _cone_check(run: Run, marks: Marks) -> Check:
    """Return whether friction never exceeds its coefficient times the normal force."""
    worst, count, where = 0.0, 0, ''
    for stamp, contacts in run.contact_forces:
        for each in contacts:
            count += 1
            normal, lateral = np.linalg.norm(each.normal), np.linalg.norm(each.lateral)
            excess = lateral - each.friction * normal
            if excess > worst:
                worst = float(excess)
                where = (f'; worst {each.bodies[0]} on {each.bodies[1]} at '
                         f'{(stamp - run.stamp[0]) * 1e-9:.4g} s')
    if not count:
        return not_applicable(_NAMES[0], 'no contact force is recorded: the arm touched nothing, '
                              'or monitor_rate is 0')
    return judge(_NAMES[0], worst, marks['contact_cone'], 'N',
                 f'friction exceeds its coefficient times the normal force by at most '
                 f'{worst:.3g} N in {number_of(count, "recorded contact")}{where}', contacts=count)


def _passivity_check(run: Run, marks: Marks) -> Check:
    """Return whether bodies without a drive never give energy to the arm."""
    if any(body.free or body.restitution > 0.0 for body in run.required_sim.world.bodies):
        return not_applicable(_NAMES[1], 'a body of the world moves or bounces: it may give back '
                              'what it has received')
    rows = np.flatnonzero(run.steps)
    torque = run.required_contact[rows + 1].mean(axis=1)
    way = run.exact.q[rows + 1] - run.exact.q[rows]
    work = np.cumsum(np.einsum('ni,ni->n', torque, way))
    # a contact that yields stores F^2 / 2k at most, and a rigid one pushes out what went in
    stored = _elastic_energy(run, rows)
    gained = float(np.maximum(work - np.minimum.accumulate(np.minimum(work, 0.0)) - stored,
                              0.0).max(initial=0.0))
    lost = -float(work[-1]) if len(work) else 0.0
    return judge(_NAMES[1], gained, marks['contact_energy'], 'J',
                 f'contact gives the arm at most {gained:.3g} J more than it has stored and takes '
                 f'{lost:.4g} J in all', dissipated_J=lost)


def _elastic_energy(run: Run, rows: np.ndarray) -> np.ndarray:
    """Return the most that contacts can have stored up to each row [J], shape (m,)."""
    stiffness = [body.stiffness for body in run.required_sim.world.bodies if body.stiffness > 0.0]
    if not stiffness:
        return np.zeros(len(rows))
    force = np.abs(tool_force(run)[rows + 1, :3]).sum(axis=1)
    return np.maximum.accumulate(0.5 * force**2 / min(stiffness))


def tool_force(run: Run) -> np.ndarray:
    """
    Return the tool wrench equivalent to the contact torque, if all contact is at the tool.

    Returned: J^-T times the mean of each period's contact torque: force [N] and torque [N m] in
    base at the origin of ``tool0``, up to each state; zero in the first row, (n, 6).
    """
    wrench = np.zeros((len(run.stamp), 6))
    torque = run.required_contact.mean(axis=1)
    touched = np.flatnonzero(torque.any(axis=1))
    touched = touched[touched > 0]
    arm, q = run.required_sim.arm, run.exact.q
    if len(touched):
        J = jacobian(q[touched - 1] + arm.angle_offset, arm)
        wrench[touched] = np.linalg.solve(np.swapaxes(J, 1, 2), torque[touched][..., None])[..., 0]
    return wrench


def _observer_check(run: Run, marks: Marks) -> tuple[Check, dict[str, Any]]:
    """Return the momentum observer's estimate against the recorded torque of the contacts."""
    if not run.substeps or run.noisy:
        return not_applicable(_NAMES[2], 'the exact states are not recorded'), {}
    q, qd, effort = run.exact
    estimate = external_torque(q, qd, effort, run.h, run.required_sim.arm, OBSERVER_GAIN,
                               run.steps)
    truth = first_order(run.required_contact[1:].mean(axis=1), OBSERVER_GAIN, run.h, run.steps)
    other = _other_external(run)
    if other:
        return not_applicable(_NAMES[2], f'{other} acts as well, which the observer cannot '
                              'distinguish from contact'), {'observer': (estimate, truth)}
    size = float(np.abs(truth).max())
    error = float(np.abs(estimate - truth).max())
    if size < 1e-3:
        return not_applicable(_NAMES[2], 'the arm touched nothing'), {
            'observer': (estimate, truth)}
    joint = int(np.abs(estimate - truth).max(axis=0).argmax())
    return judge(_NAMES[2], error / size, marks['observer'], '1',
                 f'the momentum observer finds the contact torque within {error:.3g} N m of up to '
                 f'{size:.4g} N m, worst at {JOINT_NAMES[joint]}',
                 joint=JOINT_NAMES[joint]), {'observer': (estimate, truth)}


def _other_external(run: Run) -> str:
    """Return what else acts on the joints that the arm record does not hold; empty for nothing."""
    given = run.required_sim.parameters
    if any(event.kind == 'wrench' for event in run.events):
        return 'a wrench'
    changed = {event.values.get('name') for event in run.events if event.kind == 'parameter'}
    for parameter in SIM_PARAMETERS:
        part = parameter.name.partition('.')[0]
        if part in ('payload', 'friction') and (
                given[parameter.name] != parameter.default or parameter.name in changed):
            return part
    return ''
