"""A run whose effort is stated to be something else than the torque that acted."""

from dataclasses import replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics

#: Cosine between effort and torque of a joint whose sign is right.
SIGN_COSINE = 0.95


def with_effort_meaning(run: Run, meaning: str | None) -> Run:
    """
    Return the run with its effort in N m, gravity included, as far as the meaning allows.

    ``gravity_excluded`` adds the gravity of the arm, ``other_sign`` turns the sign, of
    the joints alone that the arm shows to be turned where these are some, ``current``
    moves the numbers to the motor currents; ``target`` (the torque of a reference at rest) stays
    as it is and is compared with gravity alone.

    """
    if meaning is None:
        return run
    states = run.states
    if meaning == 'gravity_excluded':
        if run.law_record is None:
            raise InputError(f'{run.name}: gravity is of an arm; give it: --arm NAME')
        arm = run.law_record.arm
        effort = states.effort + gravity_torque(states.q + arm.angle_offset, arm)
        run = replace(run, states=states._replace(effort=effort))
    elif meaning == 'other_sign':
        run = replace(run, states=states._replace(effort=_signs(run) * states.effort))
    elif meaning == 'current':
        unknown = np.full(states.effort.shape, np.nan)
        run = replace(run, states=states._replace(effort=unknown), current=states.effort)
    elif meaning == 'target':
        run = replace(run, follows_reference=False)
    return replace(run, effort_meaning=meaning)


def _signs(run: Run) -> np.ndarray:
    """Return -1 for the joints whose effort is not that of the arm as it is, or for all, (6,)."""
    if run.law_record is None:
        return np.full(6, -1.0)
    arm, (q, qd, effort) = run.law_record.arm, run.states
    torque = inverse_dynamics(q + arm.angle_offset, qd, np.gradient(qd, run.t, axis=0), arm)
    alike = np.nansum(effort * torque, axis=0) > SIGN_COSINE * np.sqrt(
        np.nansum(effort**2, axis=0) * np.nansum(torque**2, axis=0))
    return np.where(alike & (not alike.all()), 1.0, -1.0)
