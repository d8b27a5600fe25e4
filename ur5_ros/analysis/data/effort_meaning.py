"""A run whose effort is stated to be something else than the torque that acted."""

from dataclasses import replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: Cosine between effort and torque of a joint whose sign is right.
SIGN_COSINE = 0.95

#: A joint whose effort is this many times its torque, or less, beside friction has the other sign.
TURNED = -0.5

#: Speed above which the direction of friction counts [rad/s].
MOVING = 1e-3


def with_effort_meaning(run: Run, meaning: str | None) -> Run:
    """
    Return the run with its effort in N m, gravity included, as far as the meaning allows.

    ``gravity_excluded`` adds the gravity of the arm, ``other_sign`` turns the sign, of
    the joints alone that the arm shows to be turned where these are some, ``current``
    moves the numbers to the motor currents; ``target`` (the torque of a reference at rest) stays
    as it is and is compared with gravity alone.  Where the arm shows that torque without gravity,
    or gravity, has the other sign, it is turned and a remark says so.

    """
    if meaning is None:
        return run
    states = run.states
    if meaning == 'gravity_excluded':
        if run.law_record is None:
            raise InputError(f'{run.name}: gravity is of an arm; give it: --arm NAME')
        arm = run.law_record.arm
        gravity = gravity_torque(states.q + arm.angle_offset, arm)
        run = _turned(run, _torque(run, arm) - gravity, 1.0)
        run = replace(run, states=run.states._replace(effort=run.states.effort + gravity))
    elif meaning == 'other_sign':
        run = replace(run, states=states._replace(effort=_signs(run) * states.effort))
    elif meaning == 'current':
        unknown = np.full(states.effort.shape, np.nan)
        run = replace(run, states=states._replace(effort=unknown), current=states.effort)
    elif meaning == 'target':
        if run.law_record is not None:
            arm = run.law_record.arm
            run = _turned(run, gravity_torque(states.q + arm.angle_offset, arm))
        run = replace(run, follows_reference=False)
    return replace(run, effort_meaning=meaning)


def _torque(run: Run, arm: ArmParameters) -> np.ndarray:
    """Return the torque of an arm in each state, (n, 6) [N m]."""
    q, qd, _ = run.states
    return inverse_dynamics(q + arm.angle_offset, qd, np.gradient(qd, run.t, axis=0), arm)


def _turned(run: Run, torque: np.ndarray, constant: float = 0.0) -> Run:
    """
    Return the run with the efforts turned of joints whose effort is against a torque.

    ``constant``: 1 where the effort may have a constant besides, else 0.
    """
    effort, qd = run.states.effort, run.states.qd
    times, whole = np.zeros(6), np.isfinite(effort).all(axis=1)
    moving = np.where(np.abs(qd) > MOVING, qd, 0.0)
    for joint in range(6):
        x = np.column_stack([torque[:, joint], moving[:, joint], np.sign(moving[:, joint]),
                             np.full(len(effort), constant)])[whole]
        if len(x) and np.any(x[:, 0]):
            size = np.maximum(np.abs(x).max(axis=0), 1e-300)
            value, *_ = np.linalg.lstsq(x / size, effort[whole, joint], rcond=1e-9)
            times[joint] = value[0] / size[0]
    against = times < TURNED
    if not against.any():
        return run
    if not (times > -TURNED).any():  # no joint shows the right sign
        against[:] = True
    named = '' if against.all() else ' at ' + ', '.join(
        name for name, each in zip(JOINT_NAMES, against, strict=True) if each)
    return replace(
        run, states=run.states._replace(effort=np.where(against, -1.0, 1.0) * effort),
        remarks=(*run.remarks, f'the effort has the other sign{named}: it was turned'))


def _signs(run: Run) -> np.ndarray:
    """Return -1 for the joints whose effort is not that of the arm as it is, or for all, (6,)."""
    if run.law_record is None:
        return np.full(6, -1.0)
    effort = run.states.effort
    torque = _torque(run, run.law_record.arm)
    alike = np.nansum(effort * torque, axis=0) > SIGN_COSINE * np.sqrt(
        np.nansum(effort**2, axis=0) * np.nansum(torque**2, axis=0))
    return np.where(alike & (not alike.all()), 1.0, -1.0)
