"""Values that travel between plant, law, nodes and bags: plain arrays of agreed shape and unit."""

from typing import NamedTuple

import numpy as np

#: Joint order, once and for all (the names of ur_description).
JOINT_NAMES = (
    'shoulder_pan_joint',
    'shoulder_lift_joint',
    'elbow_joint',
    'wrist_1_joint',
    'wrist_2_joint',
    'wrist_3_joint',
)


def stamp_of_period(k: int, control_rate: int) -> int:
    """
    Return the stamp of state ``k``: round(k 1e9 / control_rate), in integer arithmetic.

    Parameters
    ----------
    k : int
        Control period, counted from 1.
    control_rate : int
        Control periods per second [Hz].

    Returns
    -------
    int
        Simulated time [ns], halves rounded up.

    """
    return (2 * k * 1_000_000_000 + control_rate) // (2 * control_rate)


class ArmState(NamedTuple):
    """
    State of the arm at the start of a control period.

    Angles are the manufacturer's, q_UR; the effort is the one that acted during the period before.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import ArmState
    >>> state = ArmState(stamp=2_000_000, q=np.zeros(6), qd=np.zeros(6), effort=np.zeros(6))
    >>> state.q.shape
    (6,)

    """

    stamp: int
    """Simulated time [ns]."""
    q: np.ndarray
    """Joint positions [rad], shape (6,)."""
    qd: np.ndarray
    """Joint velocities [rad/s], shape (6,)."""
    effort: np.ndarray
    """Joint torques that acted up to this state, after limits [N m], shape (6,)."""


class Reference(NamedTuple):
    """
    What the law is asked to follow at one instant, in the manufacturer's angles.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import Reference
    >>> Reference(q=np.full(6, 0.1), qd=np.zeros(6), qdd=np.zeros(6)).q.shape
    (6,)

    """

    q: np.ndarray
    """Wanted joint positions [rad], shape (..., 6)."""
    qd: np.ndarray
    """Wanted joint velocities [rad/s], shape (..., 6)."""
    qdd: np.ndarray
    """Wanted joint accelerations [rad/s^2], shape (..., 6)."""


class Torque(NamedTuple):
    """
    Commanded joint torque and the parts that it is the sum of, each of shape (6,) [N m].

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import Torque
    >>> inertial, feedback, coriolis, gravity = np.eye(4, 6)
    >>> Torque(np.ones(6), inertial, feedback, coriolis, gravity)._fields
    ('total', 'inertial', 'feedback', 'coriolis', 'gravity')

    """

    total: np.ndarray
    """The command: the sum of the parts, after the law's own limits."""
    inertial: np.ndarray
    """M(q) qdd*: feed-forward of the wanted acceleration."""
    feedback: np.ndarray
    """M(q) (-Kd e' - Kp e), or the plain PD term in the modes that do not weigh it by M."""
    coriolis: np.ndarray
    """C(q, qd) qd."""
    gravity: np.ndarray
    """g(q); zero where the effort convention leaves gravity to the robot."""
