"""Targets by topic: message in, a motion begun or a refusal."""

from typing import Any

import numpy as np

from ur5_ros.cdr.decoded import force_and_torque, stamp_of
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.targets import pose_matrix
from ur5_ros.nodes.control.cycle import ControlCycle
from ur5_ros.nodes.ros.messages import read_message
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import Topics


class ControlInputs:
    """The subscriptions for targets."""

    def __init__(self, topics: Topics, recording: Recording, cycle: ControlCycle) -> None:
        self._recording = recording
        self._cycle = cycle
        self.subscriptions: dict[int, tuple[str, int, Any]] = {}
        """Number of a subscription to topic, number to record under, what takes the bytes."""
        for role, take in (('target_joints', self._take_joints), ('target_pose', self._take_pose),
                           ('joint_trajectory', self._take_trajectory), ('path', self._take_path),
                           ('target_wrench', self._take_wrench)):
            number, record = topics.subscribe(role)
            self.subscriptions[number] = (topics.names[role], record, take)

    def _take_joints(self, record: int, data: bytes) -> None:
        message = read_message('sensor_msgs/msg/JointState', data)
        self._cycle.controller.target_joints(message['name'], message['position'])
        self._recording.write(record, data)

    def _take_pose(self, record: int, data: bytes) -> None:
        message = read_message('geometry_msgs/msg/PoseStamped', data)
        self._cycle.controller.target_pose(
            _matrix(message['pose']), message['header']['frame_id'])
        self._recording.write(record, data)

    def _take_trajectory(self, record: int, data: bytes) -> None:
        message = read_message('trajectory_msgs/msg/JointTrajectory', data)
        self._cycle.controller.joint_trajectory(
            message['joint_names'], [trajectory_point(point) for point in message['points']],
            stamp_of(message['header']))
        self._recording.write(record, data)

    def _take_path(self, record: int, data: bytes) -> None:
        message = read_message('nav_msgs/msg/Path', data)
        poses = message['poses']
        matrices = np.array([_matrix(pose['pose']) for pose in poses]).reshape(-1, 4, 4)
        self._cycle.controller.path(
            matrices, [stamp_of(pose['header']) for pose in poses], message['header']['frame_id'])
        self._recording.write(record, data)

    def _take_wrench(self, record: int, data: bytes) -> None:
        message = read_message('geometry_msgs/msg/WrenchStamped', data)
        self._cycle.controller.target_wrench(
            *force_and_torque(message['wrench']), message['header']['frame_id'])
        self._recording.write(record, data)


def trajectory_point(message: dict[str, Any]) -> TrajectoryPoint:
    """Return a trajectory_msgs/JointTrajectoryPoint as the controller takes it."""
    since = message['time_from_start']
    return TrajectoryPoint(
        time_from_start=int(since['sec']) * 1_000_000_000 + int(since['nanosec']),
        positions=message['positions'], velocities=message['velocities'],
        accelerations=message['accelerations'], effort=message['effort'])


def _matrix(pose: dict[str, Any]) -> np.ndarray:
    position, turn = pose['position'], pose['orientation']
    return pose_matrix([position[axis] for axis in 'xyz'], [turn[axis] for axis in 'xyzw'])
