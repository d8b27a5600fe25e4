"""
Inverse kinematics: every joint configuration that brings the flange to a pose.

Angles are those of the arm record, q_model = q_UR + ``arm.angle_offset``; poses stand in ``base``.
The derivation is the paper's (section II-D), its misprints corrected (docs/equations.md), in terms
of atan2 alone, which keeps all digits where acos loses half of them.
"""

from dataclasses import replace
from math import prod
from typing import NamedTuple

import numpy as np
from numpy import empty

from ur5_ros.errors import InputError
from ur5_ros.model import calibration
from ur5_ros.model.angle_wrapping import TURN, limits_of_model, turns_allowed
from ur5_ros.model.kernels import inverse_kinematics as kernels
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.parameters import ArmParameters, Limits
from ur5_ros.model.poses import check_pose, single_pose, unreachable

_tuple = tuple.__new__  # a third of the time of the named tuple's own constructor
_NO_MASK = empty(0, dtype=bool)
_ZERO = np.zeros(1)
_SLOTS = [np.array([i for i in range(8) if mask >> i & 1], dtype=np.int64) for mask in range(256)]
_ALL = _SLOTS[255]
for _slots in (_ZERO, *_SLOTS):
    _slots.flags.writeable = False


class Solutions(NamedTuple):
    """All solutions of one pose, in the order of their branches."""

    q: np.ndarray
    """Joint positions [rad] in (-pi, pi], shape (n, 6), n at most 8."""
    branch: np.ndarray
    """Branch of each solution, shape (n,): 4 shoulder + 2 elbow + wrist, see the properties."""
    wrist_singular: bool
    """True where some solution has sin q5 = 0, so that its q6 was chosen freely."""
    reason: str
    """Why there is no solution; empty where there is one."""

    @property
    def shoulder(self) -> list[str]:
        """'left' or 'right': on which side of its reaching direction the arm carries the wrist."""
        return ['left' if branch < 4 else 'right' for branch in self.branch]

    @property
    def elbow(self) -> list[str]:
        """'up' or 'down': above or below the line from shoulder to wrist in a forward reach."""
        return ['down' if branch & 2 else 'up' for branch in self.branch]

    @property
    def wrist(self) -> list[str]:
        """'plain' (sin q5 >= 0) or 'flipped' (sin q5 < 0)."""
        return ['flipped' if branch & 1 else 'plain' for branch in self.branch]


def inverse_kinematics(
    T: np.ndarray, arm: ArmParameters, q6: float | None = None,
    q_near: np.ndarray | None = None,
) -> Solutions:
    """
    Return all configurations that bring the flange to a pose.

    Kebria 2016, eqs. (3) to (5), corrected.  Where two branches meet (elbow outstretched or
    folded, wrist centre over axis 1) they are one solution.  Where the axes 4 and 6 are parallel
    (sin q5 = 0) q6 is free: it is ``q6`` if given, else that of ``q_near``, else zero.

    Parameters
    ----------
    T : array_like, shape (4, 4)
        Pose of ``tool0`` in ``base`` [m].
    arm : ArmParameters
        The arm; its limits are not used.
    q6 : float, optional
        Angle of joint 6 where it is free [rad].
    q_near : array_like, shape (6,), optional
        Configuration whose q6 is kept where it is free [rad].

    Returns
    -------
    Solutions
        At most eight; none with a reason where the pose is out of reach.

    Raises
    ------
    InputError
        If ``T`` is no rigid transform or a number is not finite.

    Examples
    --------
    >>> from ur5_ros import forward_kinematics, inverse_kinematics, load_arm
    >>> arm = load_arm('ur5')
    >>> pose = forward_kinematics([0.3, -1.2, 1.5, -1.9, -1.4, 0.2], arm)
    >>> inverse_kinematics(pose, arm).q.shape
    (8, 6)

    """
    if arm.calibration is not None:
        return _calibrated(T, arm, q6, q_near)
    free = _ZERO if q6 is None and q_near is None else _free_angle(q6, q_near)
    q = empty((8, 6))
    try:
        code = kernels.solve.single(T, free, arm.constants, q, _NO_MASK)
    except (TypeError, AttributeError):
        kernels.solve.prepare()
        T = single_pose(T)
        code = kernels.solve.single(T, free, arm.constants, q, _NO_MASK)
    if code == 255:
        return _tuple(Solutions, (q, _ALL, False, ''))
    if code >= kernels.NOT_RIGID:
        check_pose(T)
    slots = _SLOTS[code & 255]
    return Solutions(q[slots], slots, code >= kernels.SINGULAR,
                     '' if slots.size else unreachable(T, arm))


def inverse_kinematics_batch(
    T: np.ndarray, arm: ArmParameters, q6: np.ndarray | float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return all configurations for each of many poses.

    Parameters
    ----------
    T : array_like, shape (..., 4, 4)
        Poses of ``tool0`` in ``base`` [m].
    arm : ArmParameters
        The arm; its limits are not used.
    q6 : float or array_like, shape (...,)
        Angle of joint 6 where it is free [rad].

    Returns
    -------
    q : numpy.ndarray, shape (..., 8, 6)
        Joint positions [rad] by branch, 4 shoulder + 2 elbow + wrist; NaN where there is none.
    valid : numpy.ndarray of bool, shape (..., 8)
        Which branches have a solution of their own.

    Raises
    ------
    InputError
        If a pose is no rigid transform or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import forward_kinematics, inverse_kinematics_batch, load_arm
    >>> arm = load_arm('ur5')
    >>> poses = forward_kinematics(np.random.default_rng(1).uniform(-3.0, 3.0, (100, 6)), arm)
    >>> q, valid = inverse_kinematics_batch(poses, arm)
    >>> q.shape, bool(valid.any(axis=1).all())
    ((100, 8, 6), True)

    """
    poses = finite_array('T', T, (4, 4))
    lead = poses.shape[:-2]
    if arm.calibration is not None:
        start, _ = inverse_kinematics_batch(poses, _uncalibrated(arm), q6)
        return _refined(poses.reshape(-1, 4, 4), start.reshape(-1, 8, 6), arm, lead)
    count = prod(lead)
    free = np.ascontiguousarray(np.broadcast_to(finite_array('q6', q6, ()), lead).reshape(-1))
    q, valid = empty((*lead, 8, 6)), empty((*lead, 8), dtype=bool)
    if count:
        code = kernels.solve.run(count, [poses.reshape(-1, 4), free], [arm.constants],
                                 [q.reshape(-1, 6), valid.reshape(-1)])
        if code:
            check_pose(poses)
    return q, valid


def nearest_solution(
    T: np.ndarray, q_near: np.ndarray, arm: ArmParameters, limits: Limits | None = None,
) -> np.ndarray:
    """
    Return the configuration nearest to another one that brings the flange to a pose.

    All branches and all turns by 2 pi within the limits compete; the least sum of squares wins.

    Parameters
    ----------
    T : array_like, shape (4, 4)
        Pose of ``tool0`` in ``base`` [m].
    q_near : array_like, shape (6,)
        Configuration to stay close to, angles of the arm record [rad].
    arm : ArmParameters
        The arm.
    limits : Limits, optional
        Position limits in the manufacturer's angles, as everywhere (``arm.angle_offset`` is
        added here); those of the arm by default.

    Returns
    -------
    numpy.ndarray, shape (6,)
        Joint positions, angles of the arm record [rad].

    Raises
    ------
    InputError
        If the pose is out of reach, no rigid transform, or the limits exclude every branch.

    Examples
    --------
    >>> from ur5_ros import forward_kinematics, load_arm, nearest_solution
    >>> arm = load_arm('ur5')
    >>> q = [0.3, -1.2, 1.5, -1.9, -1.4, 0.2]
    >>> nearest_solution(forward_kinematics(q, arm), q, arm, arm.limits).round(6)
    array([ 0.3, -1.2,  1.5, -1.9, -1.4,  0.2])

    """
    q_near = finite_array('q_near', q_near, (6,))
    lower, upper = limits_of_model(arm, limits)
    solutions = inverse_kinematics(T, arm, q_near=q_near)
    if solutions.reason:
        raise InputError(f'T: {solutions.reason}')
    q = solutions.q
    least, most = turns_allowed(q, lower, upper)
    q = q + TURN * np.clip(np.round((q_near - q) / TURN), least, most)
    allowed = np.all(least <= most, axis=-1)
    if not np.any(allowed):
        raise InputError(_excluded(solutions.q, least > most, limits or arm.limits, arm))
    distance = np.where(allowed, np.sum((q - q_near) ** 2, axis=-1), np.inf)
    return np.clip(q[np.argmin(distance)], lower, upper)


#: Shifts of a pose at an edge of reach [m], for a start where the DH table has no solution.
_SHIFTS = (2e-3, 1e-2)


def _uncalibrated(arm: ArmParameters) -> ArmParameters:
    return replace(arm, calibration=None)


def _refined(poses: np.ndarray, start: np.ndarray, arm: ArmParameters,
             lead: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the calibrated solution of each branch (n, 8, 6) of the closed form, and which."""
    assert arm.calibration is not None
    plain = _uncalibrated(arm)
    wrist = poses[:, :3, 3] - arm.d[5] * poses[:, :3, 2]
    for direction in (wrist * [1.0, 1.0, 0.0], -wrist):  # out of axis 1, and into reach
        unit = direction / np.maximum(np.linalg.norm(direction, axis=1), 1e-9)[:, None]
        for shift in _SHIFTS:
            shifted = poses.copy()
            shifted[:, :3, 3] += shift * unit
            other, _ = inverse_kinematics_batch(shifted, plain)
            start = np.where(np.isfinite(start), start, other.reshape(start.shape))
    every = np.repeat(poses, 8, axis=0)
    q = calibration.solve_from(every, start.reshape(-1, 6), arm.calibration).reshape(start.shape)
    q = (q + np.pi) % (2.0 * np.pi) - np.pi
    valid = np.array([calibration.distinct(each) for each in q]).reshape(-1, 8)
    q[~valid] = np.nan
    return q.reshape(*lead, 8, 6), valid.reshape(*lead, 8)


def _calibrated(T: np.ndarray, arm: ArmParameters, q6: float | None,
                q_near: np.ndarray | None) -> Solutions:
    """Return all solutions of a calibrated arm: each branch of the closed form, refined."""
    pose = single_pose(T)
    check_pose(pose)
    free = _ZERO if q6 is None and q_near is None else _free_angle(q6, q_near)
    plain = _uncalibrated(arm)
    nominal = inverse_kinematics(pose, plain, q6, q_near)
    start, _ = inverse_kinematics_batch(pose, plain, float(free[0]))
    q, valid = _refined(pose[None], start[None], arm, ())
    slots = np.flatnonzero(valid)
    return Solutions(q[slots], slots, nominal.wrist_singular,
                     '' if slots.size else nominal.reason or unreachable(pose, plain))


def _free_angle(q6: float | None, q_near: np.ndarray | None) -> np.ndarray:
    if q6 is not None:
        return finite_array('q6', q6, ()).reshape(1)
    return finite_array('q_near', q_near, (6,))[5:6]


def _excluded(q: np.ndarray, outside: np.ndarray, limits: Limits, arm: ArmParameters) -> str:
    if np.all(outside.any(axis=0)) or not np.any(outside.all(axis=0)):
        joint = int(np.argmax(outside.sum(axis=0)))
    else:
        joint = int(np.argmax(outside.all(axis=0)))
    found = ', '.join(f'{x:.4f}' for x in np.unique(np.round(q[:, joint]
                                                            - arm.angle_offset[joint], 4)))
    return (f'limits exclude all {len(q)} solutions: joint {joint + 1} may be '
            f'{limits.lower[joint]:.4f} to {limits.upper[joint]:.4f} rad and the pose needs '
            f'{found} (+-2 pi); widen the limits or give another pose')
