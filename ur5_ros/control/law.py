"""The laws to choose from, and the limits on the torque that they send."""

import numpy as np

from ur5_ros.config.parameters import HOME
from ur5_ros.control.computed_torque import computed_torque
from ur5_ros.control.gains import Gains
from ur5_ros.model.dynamics import dynamics_terms, gravity_torque
from ur5_ros.model.inverse_kinematics import inverse_kinematics_batch
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

#: Modes in which the gains are [N m/rad] and [N m s/rad], not weighed by M.
PLAIN_MODES = ('gravity_pd', 'pd', 'impedance')

_NONE = np.zeros(6)
_NONE.flags.writeable = False


def torque_of(
    mode: str,
    state: ArmState,
    reference: Reference,
    arm: ArmParameters,
    gains: Gains,
) -> Torque:
    """
    Return the joint torque of a mode, with its parts, before any limit.

    ``computed_torque`` is eq (11).  ``pd``: -Kp e - Kd e'.  ``gravity_pd``: the same and g(q),
    what most robots run.  ``impedance``: the same, M qdd* and C qd as well, so that the arm
    yields like a spring of stiffness Kp about a reference that it would follow by itself.

    Parameters
    ----------
    mode : str
        One of the four.
    state : ArmState
        Measured state.
    reference : Reference
        What to follow.
    arm : ArmParameters
        The arm that the law believes in.
    gains : Gains
        KP, KD.

    Returns
    -------
    Torque
        The total and its parts [N m].

    """
    if mode == 'computed_torque':
        return computed_torque(state, reference, arm, gains)
    feedback = -(gains.kp @ (state.q - reference.q)) - gains.kd @ (state.qd - reference.qd)
    if mode == 'pd':
        return Torque(feedback, _NONE, feedback, _NONE, _NONE)
    angles = state.q + arm.angle_offset
    if mode == 'gravity_pd':
        gravity = gravity_torque(angles, arm)
        return Torque(feedback + gravity, _NONE, feedback, _NONE, gravity)
    inertia, coriolis, gravity = dynamics_terms(angles, state.qd, arm)
    inertial, velocity_torque = inertia @ reference.qdd, coriolis @ state.qd
    total = inertial + feedback + velocity_torque + gravity
    return Torque(total, inertial, feedback, velocity_torque, gravity)


def within_limits(
    torque: Torque,
    gravity_excluded: bool,
    effort_limit: np.ndarray,
    last: np.ndarray | None,
    largest_change: float,
) -> tuple[Torque, str]:
    """
    Return the command within the limits, its direction kept, and which limits acted.

    Parameters
    ----------
    torque : Torque
        The whole joint torque and its parts.
    gravity_excluded : bool
        Whether the robot adds g(q) itself: it is then left out of the command, and the limits
        hold for the sum.
    effort_limit : numpy.ndarray, shape (6,)
        Largest joint torque [N m].
    last : numpy.ndarray, shape (6,), or None
        The command before [N m]; None = there is none to compare with.
    largest_change : float
        Largest change of any joint torque since then [N m].

    Returns
    -------
    Torque
        ``total`` scaled where a limit acts; the parts as the law made them.
    str
        '' or 'effort', 'rate', 'effort, rate'.

    """
    added = _NONE
    if gravity_excluded:
        added = torque.gravity
        torque = torque._replace(
            total=torque.inertial + torque.feedback + torque.coriolis, gravity=_NONE)
    total, acted = torque.total, []
    whole = total + added if gravity_excluded else total
    if any(not -limit <= value <= limit
           for value, limit in zip(whole.tolist(), effort_limit.tolist(), strict=True)):
        total = effort_scale(total, added, effort_limit) * total
        acted.append('effort')
    if last is not None and np.abs(total - last).max() > largest_change:
        total = last + rate_scale(total - last, largest_change) * (total - last)
        acted.append('rate')
    return (torque._replace(total=total), ', '.join(acted)) if acted else (torque, '')


def effort_scale(total: np.ndarray, added: np.ndarray, limit: np.ndarray) -> float:
    """
    Return the largest factor up to 1 that keeps every joint torque within its limit.

    One factor for all joints: the direction of the torque, and so of the motion, is kept.

    Parameters
    ----------
    total : numpy.ndarray, shape (6,)
        The command [N m].
    added : numpy.ndarray, shape (6,)
        What the robot adds to it itself [N m].
    limit : numpy.ndarray, shape (6,)
        Largest joint torque [N m].

    Returns
    -------
    float
        Between 0 and 1.

    """
    room = limit - np.sign(total) * added
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        factor = np.where(total != 0.0, room / np.abs(total), np.inf)
    return float(min(1.0, max(0.0, factor.min())))


def rate_scale(change: np.ndarray, largest: float) -> float:
    """
    Return the largest factor up to 1 that keeps every change of torque within ``largest``.

    Parameters
    ----------
    change : numpy.ndarray, shape (6,)
        Change of the command since the one before [N m].
    largest : float
        Allowed change of any joint [N m].

    Returns
    -------
    float
        Between 0 and 1.

    """
    biggest = float(np.abs(change).max())
    return 1.0 if biggest <= largest else largest / biggest


def warm_up(arm: ArmParameters, gains: Gains) -> None:
    """
    Have everything that a control period needs compiled and loaded.

    Parameters
    ----------
    arm : ArmParameters
        The law's arm.
    gains : Gains
        Its gains.

    """
    home, zero = np.array(HOME), np.zeros(6)
    for mode in ('computed_torque', 'gravity_pd'):
        torque_of(mode, ArmState(0, home, zero, zero), Reference(home, zero, zero), arm, gains)
    inverse_kinematics_batch(np.eye(4)[None], arm)
