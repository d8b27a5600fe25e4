"""Experiments of ``config/experiments`` as trajectories of a given arm."""

from typing import NamedTuple

import numpy as np

from ur5_ros.config.experiments import (
    Experiment,
    JointStep,
    JointWaves,
    ToolCircle,
    ToolPolygon,
    ToolWaves,
)
from ur5_ros.config.worlds import Solid, base_pose
from ur5_ros.control.cartesian_path import straight_legs
from ur5_ros.control.profiles import ToolSamples, joint_waves, tool_circle, tool_waves
from ur5_ros.control.tool_motion import Branch, check_limits, follow, tool_motion
from ur5_ros.control.trajectory import SECOND, Sampled, Step, Trajectory, grid
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference

#: Largest number of grid points of a table [count]; a longer experiment has a coarser grid.
_LARGEST_TABLE = 500_000


class ExperimentTrajectory(NamedTuple):
    """An experiment ready to run."""

    trajectory: Trajectory
    """The reference along time."""
    branch: Branch | None
    """The inverse-kinematics branch followed; None for motions given in joints."""


def initial_positions(spec: Experiment, arm: ArmParameters) -> np.ndarray:
    """
    Return where the arm should stand when the experiment begins: q*(0) + e0.

    Returned: manufacturer's joint angles [rad], (6,).
    """
    zero = np.zeros(1)
    if isinstance(spec, JointStep):
        first = _step(spec, arm).at(0).q
    elif isinstance(spec, JointWaves):
        first = joint_waves(zero, spec).q[0]
    else:
        first = follow(_tool_samples(spec, zero, arm), zero, _start(spec), arm, 0.0)[0].q[0]
    return first + np.array(spec.initial_error)


def experiment_trajectory(
    spec: Experiment,
    arm: ArmParameters,
    control_rate: int,
    singularity_margin: float,
) -> ExperimentTrajectory:
    """
    Return the motion of an experiment, computed at once for every control period.

    ``control_rate``: control periods a second [Hz].
    """
    rate = min(control_rate, int(_LARGEST_TABLE / spec.duration))
    try:
        if isinstance(spec, JointStep):
            return ExperimentTrajectory(_step(spec, arm), None)
        if isinstance(spec, JointWaves):
            times = grid(spec.duration, rate)
            table = joint_waves(times, spec)
            check_limits(table, times, arm)
            return ExperimentTrajectory(Sampled(times, rate, table), None)
        motion, branch = tool_motion(lambda times: _tool_samples(spec, times, arm),
                                     spec.duration, rate, _start(spec), arm, singularity_margin)
    except InputError as refusal:
        raise InputError(f'experiment {spec.name}, arm {arm.name}: {refusal}') from None
    return ExperimentTrajectory(motion, branch)


def _start(spec: Experiment) -> np.ndarray:
    return np.deg2rad(spec.start_degrees)


def _start_pose(spec: Experiment, arm: ArmParameters) -> np.ndarray:
    if spec.start_position is None:
        return forward_kinematics(_start(spec) + arm.angle_offset, arm)
    return base_pose(Solid(shape='sphere', position=spec.start_position,
                           rpy_degrees=spec.start_rpy_degrees))


def _tool_samples(
    spec: ToolWaves | ToolCircle | ToolPolygon,
    times: np.ndarray,
    arm: ArmParameters,
) -> ToolSamples:
    start = _start_pose(spec, arm)
    if isinstance(spec, ToolWaves):
        return tool_waves(times, spec, start)
    if isinstance(spec, ToolCircle):
        if np.linalg.norm(np.cross(spec.normal, spec.centre)) < 1e-9:
            raise InputError(f'centre {spec.centre} and normal {spec.normal} make no circle; '
                             'give a centre away from the start and a normal across to it')
        return tool_circle(times, spec, start)
    poses = np.broadcast_to(start, (len(spec.corners), 4, 4)).copy()
    poses[:, :3, 3] += np.array(spec.corners)
    return straight_legs(poses, np.concatenate([[0.0], np.cumsum(spec.times)]))(times)


def _step(spec: JointStep, arm: ArmParameters) -> Step:
    before = _start(spec)
    q = np.array([before, before + np.array(spec.step)])
    check_limits(Reference(q, np.zeros_like(q), np.zeros_like(q)), np.array([0.0, spec.at]), arm)
    return Step(q[0], q[1], round(spec.at * SECOND), round(spec.duration * SECOND))
