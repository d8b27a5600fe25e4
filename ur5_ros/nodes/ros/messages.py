"""Messages to signals: size judged first, joints matched by name, numbers finite."""

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5_ros.cdr.codec import decode
from ur5_ros.cdr.decoded import stamp_of
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.errors import InputError
from ur5_ros.signals import ArmState, joint_order, joint_values

#: Largest message that is decoded, by what it carries [bytes].
MOST_BYTES = {
    'sensor_msgs/msg/JointState': 65_536,
    'std_msgs/msg/Float64': 64,
    'std_msgs/msg/Float64MultiArray': 65_536,
    'std_msgs/msg/String': 65_536,
    'geometry_msgs/msg/WrenchStamped': 4_096,
    'geometry_msgs/msg/PoseStamped': 4_096,
    'trajectory_msgs/msg/JointTrajectory': 8_000_000,
    'nav_msgs/msg/Path': 4_000_000,
}

#: Refused messages that are larger are not recorded either [bytes].
MOST_RECORDED = 65_536


def type_name(message_type: type) -> str:
    """Return ``package/msg/Name`` of a message class."""
    return f'{message_type.__module__.partition(".")[0]}/msg/{message_type.__name__}'


def message_class(type_name: str) -> type:
    """Return the message class of ``package/msg/Name``; ImportError or AttributeError if none."""
    package, _, name = type_name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


def read_message(type_name: str, data: bytes) -> dict[str, Any]:
    """Return the fields of a message that is not too large."""
    if len(data) > MOST_BYTES[type_name]:
        raise InputError(f'{len(data)} bytes; at most {MOST_BYTES[type_name]} are read')
    return decode(type_name, data)


class EffortReader:
    """Commands as JointState: ``name`` and ``effort``; position and velocity are not looked at."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.layout = FixedJointState(names, fields=('effort',))
        """The layout of our own commands."""
        self._layouts = (self.layout, FixedJointState(names))

    def read(self, data: bytes) -> tuple[int, Sequence[str] | None, Any]:
        """
        Return the stamp [ns] of the state that a command answers, 0 if none, names and efforts.

        The names are None if they are ours in our order.
        """
        for layout in self._layouts:
            if layout.matches(data):
                stamp, effort = layout.stamp_and_effort(data)
                return stamp, None, effort
        message = read_message('sensor_msgs/msg/JointState', data)
        return stamp_of(message['header']), tuple(message['name']), message['effort']


class StateReader:
    """States as JointState: names, positions, velocities, and efforts where there are."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self.layout = FixedJointState(names)
        """The layout of our own states."""
        self.matches = self.layout.matches

    def read(self, data: bytes) -> ArmState:
        """Return the state; its numbers are validated by the controller."""
        if self.layout.matches(data):
            return ArmState(*self.layout.decode(data))  # the controller asks whether it is finite
        message = read_message('sensor_msgs/msg/JointState', data)
        order = joint_order(message['name'], self._names)
        effort = message['effort']
        return ArmState(
            stamp_of(message['header']), joint_values('positions', message['position'], order),
            joint_values('velocities', message['velocity'], order),
            joint_values('efforts', effort, order) if len(effort) else np.zeros(6))

