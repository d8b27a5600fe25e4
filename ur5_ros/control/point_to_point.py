"""Jerk-limited joint motion from any reference to a configuration, or to rest (ruckig)."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
import ruckig

from ur5_ros.control.trajectory import SECOND
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, Reference


class MotionLimits(NamedTuple):
    """What a point-to-point motion may use, each of shape (6,)."""

    velocity: np.ndarray
    """[rad/s]."""
    acceleration: np.ndarray
    """[rad/s^2]."""
    jerk: np.ndarray
    """[rad/s^3]."""


class PointToPoint:
    """A time-optimal synchronised motion: position, velocity and acceleration are continuous."""

    def __init__(self, trajectory: ruckig.Trajectory, end: np.ndarray, speed: np.ndarray):
        self.duration = int(np.ceil(trajectory.duration * SECOND))
        self._trajectory = trajectory
        self._end = Reference(end, speed, np.zeros(6))

    def at(self, time: int) -> Reference:
        """Return the reference; the end exactly from ``duration`` on."""
        if time >= self.duration:
            return self._end
        q, qd, qdd = self._trajectory.at_time(time / SECOND)
        return Reference(np.array(q), np.array(qd), np.array(qdd))


def point_to_point(
    start: Reference,
    target: np.ndarray,
    limits: MotionLimits,
    arm: ArmParameters,
    arrival: np.ndarray | None = None,
) -> PointToPoint:
    """
    Return the motion from a reference, moving or not, to a configuration.

    ``target`` (6,): configuration to reach [rad]; ``arrival`` (6,): velocity there [rad/s]; at
    rest by default.
    """
    _check_positions(target, target, arm)
    motion = ruckig.InputParameter(6)
    arrival = np.zeros(6) if arrival is None else arrival
    motion.target_position = target.tolist()
    motion.target_velocity = arrival.tolist()
    trajectory = _planned(motion, start, limits)
    extrema = trajectory.position_extrema
    low = np.minimum([extremum.min for extremum in extrema], target)
    high = np.maximum([extremum.max for extremum in extrema], target)
    _check_positions(np.where(low < start.q - 1e-9, low, target),
                     np.where(high > start.q + 1e-9, high, target), arm)
    return PointToPoint(trajectory, target.copy(), arrival.copy())


def smooth_stop(start: Reference, limits: MotionLimits) -> PointToPoint:
    """
    Return the motion that brings a moving reference to rest as soon as the limits allow.

    Returned: the motion; it ends where it ends.
    """
    motion = ruckig.InputParameter(6)
    motion.control_interface = ruckig.ControlInterface.Velocity
    motion.synchronization = ruckig.Synchronization.No
    trajectory = _planned(motion, start, limits)
    end, _, _ = trajectory.at_time(trajectory.duration)
    return PointToPoint(trajectory, np.array(end), np.zeros(6))


def _planned(
    motion: ruckig.InputParameter,
    start: Reference,
    limits: MotionLimits,
) -> ruckig.Trajectory:
    motion.current_position = start.q.tolist()
    motion.current_velocity = start.qd.tolist()
    motion.current_acceleration = start.qdd.tolist()
    motion.max_velocity = limits.velocity.tolist()
    motion.max_acceleration = limits.acceleration.tolist()
    motion.max_jerk = limits.jerk.tolist()
    trajectory = ruckig.Trajectory(6)
    # ruckig raises on what it cannot solve, and ValueError where its code has no name
    with suppress(ruckig.RuckigError, ValueError):
        result = ruckig.Ruckig(6).calculate(motion, trajectory)
        if result in (ruckig.Result.Working, ruckig.Result.Finished):
            return trajectory
    joint = int(np.abs(start.qd).argmax())
    raise InputError(f'no jerk-limited motion found from {start.qd[joint]:.6g} rad/s of '
                     f'{JOINT_NAMES[joint]}; ask again from rest')


def _check_positions(low: np.ndarray, high: np.ndarray, arm: ArmParameters) -> None:
    limits = arm.limits
    for joint in range(6):
        worst = high[joint] if high[joint] > limits.upper[joint] else low[joint]
        if not limits.lower[joint] <= worst <= limits.upper[joint]:
            raise InputError(f'{JOINT_NAMES[joint]} would go to {worst:.4f} rad; its limits are '
                             f'{limits.lower[joint]:.4f} to {limits.upper[joint]:.4f}')
