"""Contact in a run: friction in its cone, passivity, the external torque, contact unrecorded."""

from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.momentum_observer import external_torque, first_order
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config import SIM_PARAMETERS
from ur5_ros.config.validation import Marks
from ur5_ros.model.kinematics import jacobian
from ur5_ros.signals import JOINT_NAMES

_NAMES = ('Coulomb cone', 'contact passivity', 'external torque')

#: Gain of the momentum observer [1/s].
GAIN = 50.0

#: Where the arm stands still, a motor current beside what model and friction explain counts as a
#: contact when it lasts this long [s] and exceeds this many robust standard deviations, to which
#: the step of UR's current measurement is added [A].
LASTING, SIGMAS, CURRENT_STEP = 0.3, 8.0, 0.02
#: Joint speed that counts as still [rad/s].
STILL = 0.02


def contact_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """
    Return the checks of contact and the series for the figures.

    Parameters
    ----------
    run : Run
        The recording.
    marks : Marks
        Pass marks.

    """
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
        return not_applicable(_NAMES[0], 'no contact force is recorded: nothing was touched, or '
                              'monitor_rate is 0')
    return judge(_NAMES[0], worst, marks['contact_cone'], 'N',
                 f'friction exceeds its coefficient times the normal force by at most '
                 f'{worst:.3g} N in {count} recorded contacts{where}', contacts=count)


def _passivity_check(run: Run, marks: Marks) -> Check:
    """Return whether what does not move itself never gives energy to the arm."""
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
    Return the wrench at the tool that the contact torque comes to, if all contact is there.

    Parameters
    ----------
    run : Run
        A recording with contact torque.

    Returns
    -------
    numpy.ndarray, shape (n, 6)
        J^-T times the mean of each period's contact torque: force [N] and torque [N m] in base at
        the origin of ``tool0``, up to each state; zero in the first row.

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
    estimate = external_torque(q, qd, effort, run.h, run.required_sim.arm, GAIN, run.steps)
    truth = first_order(run.required_contact[1:].mean(axis=1), GAIN, run.h, run.steps)
    other = _other_external(run)
    if other:
        return not_applicable(_NAMES[2], f'{other} acts as well, which the observer cannot tell '
                              'from contact'), {'observer': (estimate, truth)}
    size = float(np.abs(truth).max())
    error = float(np.abs(estimate - truth).max())
    if size < 1e-3:
        return not_applicable(_NAMES[2], 'nothing was touched'), {'observer': (estimate, truth)}
    joint = int(np.abs(estimate - truth).max(axis=0).argmax())
    return judge(_NAMES[2], error / size, marks['observer'], '1',
                 f'the momentum observer finds the contact torque within {error:.3g} N m of up to '
                 f'{size:.4g} N m, worst at {JOINT_NAMES[joint]}',
                 joint=JOINT_NAMES[joint]), {'observer': (estimate, truth)}


def _other_external(run: Run) -> str:
    """Return what else acts on the joints that the arm record does not say; empty for nothing."""
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


def contact_likely(run: Run) -> tuple[list[Check], dict[str, Any]]:
    """
    Return where a real robot was probably touched while it stood still.

    Its motor currents are compared with what target torque, speed and the sign of speed explain
    over the whole recording; friction hides a push while the arm moves, so that only the time at
    rest is judged.

    """
    if run.current is None or run.sim is not None or not np.isfinite(run.states.effort).all():
        return [], {}
    surplus, spread = _unexplained_current(run)
    length = max(1, round(LASTING * run.control_rate))
    if len(surplus) <= length:
        return [], {}
    mean = _moving_mean(surplus, length)
    still = _moving_mean(np.abs(run.states.qd), length).max(axis=1) < STILL
    over = (np.abs(mean) / (spread + CURRENT_STEP)).max(axis=1) * still
    name = 'contact likely'
    if not still.any():
        return [not_applicable(name, 'the arm never stands still')], {}
    starts = np.flatnonzero(np.diff(np.concatenate([[0], (over > SIGMAS).astype(int)])) == 1)
    places = ', '.join(f'{run.t[row]:.3g} s' for row in starts[:10])
    sentence = (f'motor currents at rest tell of contact from {places} on' if len(starts) else
                'no motor current at rest tells of contact')
    return [judge(name, float(over.max()), SIGMAS, '1', sentence,
                  starts_s=run.t[starts].tolist())], {'contact_likely': over}


def _unexplained_current(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return what a robust fit leaves of each joint's current, and its robust spread [A]."""
    effort, qd = run.states.effort, run.states.qd
    current = run.required_current
    left = np.zeros(current.shape)
    for j in range(6):
        X = np.stack([np.ones(len(qd)), effort[:, j], qd[:, j], np.tanh(qd[:, j] / STILL)], axis=1)
        weight = np.ones(len(qd))
        for _ in range(20):
            fit = np.linalg.lstsq(X * weight[:, None], current[:, j] * weight, rcond=1e-6)[0]
            left[:, j] = current[:, j] - X @ fit
            size = 1.4826 * np.median(np.abs(left[:, j])) + 1e-3
            weight = 1.0 / np.sqrt(1.0 + (left[:, j] / (2.0 * size))**2)
    return left, 1.4826 * np.median(np.abs(left), axis=0)


def _moving_mean(values: np.ndarray, length: int) -> np.ndarray:
    total = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), values]), axis=0)
    return (total[length:] - total[:-length]) / length
