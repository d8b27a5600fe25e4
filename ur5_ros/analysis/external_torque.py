"""External torque on a real arm, from its own recording: motors, model, friction, observer."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.momentum_observer import external_torque, first_order
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.friction import friction_terms, friction_torque
from ur5_ros.model.parameters import ArmParameters

#: Gain of the momentum observer for recordings of about 100 Hz with measured speeds [1/s].
OBSERVER_GAIN = 10.0

#: Joint speed below which friction has no direction [rad/s].
STILL_SPEED = 0.02


def motor_torque(run: Run, arm: ArmParameters) -> np.ndarray | None:
    """
    Return the torque of the motors, friction not taken off, shape (n, 6) [N m].

    Of a log with motor currents by the arm's torque constants, of another its effort; None where
    the arm has no torque constants, or the effort is the robot's own target.

    """
    if run.current is None:
        return None if run.follows_reference else run.states.effort
    return None if arm.torque_constant is None else arm.torque_constant * run.current


class ExternalTorque(NamedTuple):
    """What a momentum observer finds beside motors, model and friction; shapes (n, 6) [N m]."""

    estimate: np.ndarray
    """External torque, with a joint at rest taken to have no friction."""
    held: np.ndarray
    """What friction of a joint at rest may hold of it, through the same filter."""


def robot_external_torque(run: Run, arm: ArmParameters) -> ExternalTorque | None:
    """
    Return the external torque on a real arm.

    ``arm``: its parameters with friction, such as ``ur5 identify`` writes them.  Returned: None
    where :func:`motor_torque` is None or holds no numbers.
    """
    torque = motor_torque(run, arm)
    if torque is None or not np.isfinite(torque).any():
        return None
    q, qd = run.states.q, run.states.qd
    load = inverse_dynamics(q + arm.angle_offset, qd, np.zeros(q.shape), arm)
    still = np.abs(qd) < STILL_SPEED
    _, level, offset = friction_terms(arm.friction, np.zeros(q.shape), load)
    known = np.where(still, 0.0, friction_torque(arm.friction, qd, load))
    held = np.where(still, level + np.abs(offset), 0.0)
    return ExternalTorque(
        external_torque(q, qd, torque - known, run.h, arm, OBSERVER_GAIN, run.steps),
        first_order(held[1:], OBSERVER_GAIN, run.h, run.steps))


def unexplained_torque(run: Run, arm: ArmParameters) -> np.ndarray | None:
    """Return the RMS of the estimate on a recording without contact, (6,) [N m]."""
    found = robot_external_torque(run, arm)
    if found is None:
        return None
    rms = np.sqrt(np.mean(found.estimate**2, axis=0))
    return rms if (rms > 0.0).all() else None
