"""Values that travel between plant, law, nodes and bags: plain arrays of agreed shape and unit."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.errors import InputError

#: Joint order, once and for all (the names of ur_description).
JOINT_NAMES = (
    'shoulder_pan_joint',
    'shoulder_lift_joint',
    'elbow_joint',
    'wrist_1_joint',
    'wrist_2_joint',
    'wrist_3_joint',
)


class JointNameError(InputError):
    """A message does not name each joint once."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason
        """'doubled joint name', 'unknown joint name' or 'missing joint name'."""


def joint_order(names: Sequence[str], joints: Sequence[str] = JOINT_NAMES) -> list[int]:
    """
    Return where each joint stands in a message.

    Parameters
    ----------
    names : sequence of str
        Names of the message, in any order.
    joints : sequence of str
        The names that are expected, in joint order.

    Returns
    -------
    list of int
        Index of joint 1, ..., 6 in ``names``.

    Raises
    ------
    JointNameError
        If a joint is doubled, unknown or missing.

    """
    if tuple(names) == tuple(joints):
        return list(range(len(joints)))
    for name in names:
        if name not in joints:
            shown = repr(name if len(name) < 60 else name[:57] + '...')
            raise JointNameError('unknown joint name', f'unknown joint {shown}; the joints are: '
                                 f'{", ".join(joints)}')
    index = {name: i for i, name in enumerate(names)}
    for i, name in enumerate(names):
        if index[name] != i:
            raise JointNameError('doubled joint name',
                                 f'joint {name} stands twice; name each joint once')
    for name in joints:
        if name not in index:
            raise JointNameError('missing joint name', f'joint {name} is missing; give all of: '
                                 f'{", ".join(joints)}')
    return [index[name] for name in joints]


def joint_values(what: str, values: Sequence[float] | np.ndarray,
                 order: Sequence[int]) -> np.ndarray:
    """
    Return a message's six values in joint order.

    Parameters
    ----------
    what : str
        Their name in error messages.
    values : sequence of float
        In the message's order.
    order : sequence of int
        From :func:`joint_order`.

    Raises
    ------
    InputError
        If there are not six, or one is not finite.

    """
    array = np.array(values, dtype=float)
    if array.shape != (6,):
        raise InputError(f'{array.size} {what} for 6 joints; give 6')
    if not np.isfinite(array).all():
        raise InputError(f'{what} hold {array[~np.isfinite(array)][0]}; give finite numbers')
    return array[list(order)]


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
    What the law follows at one instant, in the manufacturer's angles.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import Reference
    >>> Reference(q=np.full(6, 0.1), qd=np.zeros(6), qdd=np.zeros(6)).q.shape
    (6,)

    """

    q: np.ndarray
    """Desired joint positions [rad], shape (..., 6)."""
    qd: np.ndarray
    """Desired joint velocities [rad/s], shape (..., 6)."""
    qdd: np.ndarray
    """Desired joint accelerations [rad/s^2], shape (..., 6)."""


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
    """M(q) qdd*: feed-forward of the desired acceleration."""
    feedback: np.ndarray
    """M(q) (-Kd e' - Kp e), or the plain PD term in the modes that do not weigh it by M."""
    coriolis: np.ndarray
    """C(q, qd) qd."""
    gravity: np.ndarray
    """g(q); zero where the effort convention leaves gravity to the robot."""
