"""Judging a trajectory goal: tolerances and result codes as control_msgs has them."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

#: Speed below which a joint counts as stopped at the goal [rad/s] (as UR's controller file).
STOPPED_VELOCITY = 0.2


class ResultCode(IntEnum):
    """Codes of control_msgs/action/FollowJointTrajectory."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class GoalError(InputError):
    """A goal that cannot be followed."""

    def __init__(self, code: ResultCode, sentence: str):
        super().__init__(sentence)
        self.code = code


class JointTolerance(NamedTuple):
    """As control_msgs/JointTolerance: 0 = the default, -1 = no limit."""

    name: str
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


class Tolerances(NamedTuple):
    """Largest errors allowed, infinite where there is no limit."""

    path: np.ndarray
    """Rows position [rad], velocity [rad/s], acceleration [rad/s^2]; shape (3, 6)."""
    goal: np.ndarray
    """The same at the end, shape (3, 6)."""
    goal_time: float
    """Extra time to reach the goal [s], infinite = for ever."""


class Verdict(NamedTuple):
    """The end of a goal."""

    code: ResultCode
    message: str


def default_tolerances(trajectory: float, goal: float, goal_time: float) -> Tolerances:
    """
    Return the tolerances of the parameters ``constraints.*``; zero means no limit.

    ``trajectory``, ``goal``: largest joint position error on the way and at the end [rad];
    ``goal_time``: extra time [s].
    """
    path_limits = np.full((3, 6), np.inf)
    goal_limits = np.full((3, 6), np.inf)
    path_limits[0] = trajectory or np.inf
    goal_limits[0] = goal or np.inf
    goal_limits[1] = STOPPED_VELOCITY
    return Tolerances(path_limits, goal_limits, goal_time or np.inf)


def resolve_tolerances(
    default: Tolerances,
    path: Sequence[JointTolerance] = (),
    goal: Sequence[JointTolerance] = (),
    goal_time: float = 0.0,
    names: Sequence[str] = JOINT_NAMES,
) -> Tolerances:
    """
    Return the tolerances of one goal: 0 keeps the default, -1 removes the limit.

    ``goal_time``: ``goal_time_tolerance`` [s]: 0 = default, -1 = wait for ever.
    """
    time = _resolved('goal_time_tolerance', goal_time, default.goal_time)
    place = {name: joint for joint, name in enumerate(names)}
    return Tolerances(_merged('path', default.path, path, place),
                      _merged('goal', default.goal, goal, place), time)


def judge(
    tolerances: Tolerances,
    error: np.ndarray,
    past_end: float,
    names: Sequence[str] = JOINT_NAMES,
) -> Verdict | None:
    """
    Return how a goal ended, or None while it goes on.

    Before the end the path tolerances must hold; from the end on the goal succeeds as soon as the
    goal tolerances hold, and fails when they do not within the goal time.

    ``error`` (3, 6): errors of position, velocity and acceleration; NaN = not measured, not
    judged; ``past_end``: time since the end of the trajectory [s], negative before it.
    """
    size = np.abs(error)
    if past_end < 0.0:
        worst = _worst(size, tolerances.path, names)
        return None if worst is None else Verdict(
            ResultCode.PATH_TOLERANCE_VIOLATED, f'left the path: {worst}')
    worst = _worst(size, tolerances.goal, names)
    if worst is None:
        return Verdict(ResultCode.SUCCESSFUL, 'goal reached')
    if past_end > tolerances.goal_time:
        return Verdict(
            ResultCode.GOAL_TOLERANCE_VIOLATED,
            f'not at the goal {past_end:.3f} s after the end: {worst}')
    return None


def _merged(
    what: str,
    default: np.ndarray,
    given: Sequence[JointTolerance],
    place: Mapping[str, int],
) -> np.ndarray:
    merged = default.copy()
    for tolerance in given:
        if tolerance.name not in place:
            raise InputError(f'{what}_tolerance names {tolerance.name!r}; '
                             f'the joints are: {", ".join(place)}')
        for row, value in enumerate(tolerance[1:]):
            joint = place[tolerance.name]
            merged[row, joint] = _resolved(f'{what}_tolerance of {tolerance.name}', value,
                                           merged[row, joint])
    return merged


def _resolved(what: str, value: float, default: float) -> float:
    if value == 0.0:
        return default
    if value == -1.0:
        return np.inf
    if not value > 0.0:
        raise InputError(f'{what} is {value}; give a positive number, 0 for the default or -1 for '
                         'no limit')
    return value


def _worst(size: np.ndarray, limit: np.ndarray, names: Sequence[str]) -> str | None:
    beyond = size > limit  # False for NaN
    if not beyond.any():
        return None
    ratio = np.where(beyond, size / limit, 0.0)
    row, joint = divmod(int(ratio.argmax()), 6)
    quantity, unit = (('position', 'rad'), ('velocity', 'rad/s'),
                      ('acceleration', 'rad/s^2'))[row]
    return (f'{names[joint]} has a {quantity} error of {size[row, joint]:.6g} {unit}; '
            f'allowed are {limit[row, joint]:g}')
