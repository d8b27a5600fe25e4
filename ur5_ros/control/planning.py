"""From a request to its trajectory, or the reason why there is none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.control.cartesian_path import speed_path, stamped_path
from ur5_ros.control.experiment import ExperimentTrajectory
from ur5_ros.control.joint_trajectory import TrajectoryPoint, check_points, joint_spline
from ur5_ros.control.point_to_point import point_to_point, smooth_stop
from ur5_ros.control.settings import Settings
from ur5_ros.control.targets import solve_pose
from ur5_ros.control.tolerances import GoalError, ResultCode
from ur5_ros.control.tool_motion import Branch, tool_motion
from ur5_ros.control.trajectory import SECOND, Trajectory, TrajectorySequence
from ur5_ros.errors import InputError
from ur5_ros.model.frames import pose_in_base, wrench_in_base
from ur5_ros.signals import ArmState, Reference, joint_order, joint_values
from ur5_ros.wording import number_of

#: Paths have at most this many control periods [count].
_LONGEST_PATH = 500_000


class Plan(NamedTuple):
    """A trajectory to execute, and how it was chosen."""

    trajectory: Trajectory
    """Time 0 = the state answered last."""
    branch: Branch | None = None
    """Inverse-kinematics branch, where one was chosen."""


def plan_joints(
    settings: Settings,
    start: Reference,
    names: Sequence[str],
    positions: Sequence[float],
) -> Plan:
    """
    Return the jerk-limited motion to joint positions.

    ``positions``: manufacturer's angles [rad].
    """
    target = joint_values('positions', positions, joint_order(names, settings.joint_names))
    return Plan(point_to_point(start, target, settings.motion_limits, settings.arm))


def plan_pose(settings: Settings, start: Reference, pose: np.ndarray, frame: str) -> Plan:
    """
    Return the jerk-limited joint motion to a tool pose, on the nearest branch.

    ``pose`` (4, 4): desired pose; ``frame``: ``base`` or ``base_link``.
    """
    q, branch = solve_pose(pose_in_base(pose, frame, settings.prefix), start.q, settings.arm,
                           settings.max_joint_jump)
    return Plan(point_to_point(start, q, settings.motion_limits, settings.arm), branch)


def plan_trajectory(
    settings: Settings,
    start: Reference,
    names: Sequence[str],
    points: Sequence[TrajectoryPoint],
    stamp: int,
    now: int,
) -> Plan:
    """
    Return the motion of a joint trajectory, by the joint_trajectory_controller's rules.

    ``stamp``: when it starts [ns]; 0 = now; ``now``: stamp of the state answered last [ns].
    """
    try:
        order = joint_order(names, settings.joint_names)
    except InputError as error:
        raise GoalError(ResultCode.INVALID_JOINTS, str(error)) from None
    check_points(points, len(order), stamp, now, settings.allow_nonzero_end_velocity)
    return Plan(joint_spline(points, order, start, stamp - now if stamp else 0, settings.arm))


def plan_path(
    settings: Settings,
    start: Reference,
    poses: np.ndarray,
    times: Sequence[int],
    frame: str,
) -> Plan:
    """
    Return the motion to the first pose of a path and along its straight lines.

    ``poses`` (n, 4, 4): tool poses to pass; ``times``: their stamps [ns]: differences count, the
    path begins when its first pose is reached; all equal = timed by ``tool_speed``; ``frame``:
    ``base`` or ``base_link``.
    """
    poses = pose_in_base(poses, frame, settings.prefix)
    if len(poses) < 2:
        raise InputError(f'the path has {number_of(len(poses), "pose")}; give two or more, or use '
                         '~/target_pose')
    if len(times) not in (0, len(poses)):
        raise InputError(f'{number_of(len(times), "stamp")} for '
                         f'{number_of(len(poses), "pose")}; give one each, or none')
    if len(set(times)) <= 1:
        lines, duration = speed_path(poses, settings.tool_speed)
    else:
        lines = stamped_path(poses, np.array([(time - times[0]) / SECOND for time in times]))
        duration = (times[-1] - times[0]) / SECOND
    if duration * settings.control_rate > _LONGEST_PATH:
        raise InputError(f'the path takes {duration:.1f} s; at {settings.control_rate} Hz at most '
                         f'{_LONGEST_PATH / settings.control_rate:.0f} s are followed: send it in '
                         'parts')
    motion, branch = tool_motion(lines, duration, settings.control_rate, start.q, settings.arm,
                                 settings.singularity_margin)
    first = motion.at(0).q
    jump = np.abs(first - start.q)
    if jump.max() > settings.max_joint_jump:
        raise InputError(f'joint {int(jump.argmax()) + 1} would have to turn by '
                         f'{jump.max():.4f} rad to the first pose; max_joint_jump is '
                         f'{settings.max_joint_jump:g}')
    approach = point_to_point(start, first, settings.motion_limits, settings.arm)
    return Plan(TrajectorySequence(approach, motion, settings.control_rate), branch)


def plan_experiment(
    settings: Settings,
    start: Reference,
    experiment: ExperimentTrajectory | None,
) -> Plan:
    """Return the motion to where an experiment begins, and the experiment."""
    if experiment is None:
        raise InputError('no experiment is set; start the node with the parameter experiment')
    first = experiment.trajectory.at(0)
    approach = point_to_point(start, first.q, settings.motion_limits, settings.arm, first.qd)
    return Plan(TrajectorySequence(approach, experiment.trajectory, settings.control_rate),
                experiment.branch)


def plan_stop(settings: Settings, start: Reference) -> Plan:
    """Return the motion that brings the reference to rest."""
    return Plan(smooth_stop(start, settings.motion_limits))


def desired_wrench(settings: Settings, state: ArmState, force: Sequence[float],
                   torque: Sequence[float], frame: str) -> np.ndarray:
    """Return force [N] and torque [N m] that the tool should press with, in base, shape (6,)."""
    if settings.mode != 'cartesian_impedance':
        raise InputError(f'mode is {settings.mode}; set mode to cartesian_impedance first')
    return wrench_in_base(force, torque, frame, state.q, settings.arm, settings.prefix)
