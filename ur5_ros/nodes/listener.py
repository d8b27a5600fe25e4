"""The newest joint states, reference, description and events, taken when asked for."""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from ur5_ros.signals import JOINT_NAMES

_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_EVENTS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
_LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Sample(NamedTuple):
    """One joint state, and the newest reference."""

    t: float
    """Stamp [s]."""
    q: np.ndarray
    """Positions [rad], shape (6,)."""
    effort: np.ndarray
    """Efforts [N m], shape (6,); NaN where none is published."""
    reference: np.ndarray
    """Reference positions [rad], shape (6,); NaN where no reference is published."""


class Listener:
    """
    Subscriptions that keep their newest messages and are never spun.

    Best effort, so that a simulator in lockstep never waits for a viewer.

    """

    def __init__(self) -> None:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node('ur5_view', start_parameter_services=False)
        self._states = self._node.create_subscription(
            JointState, '/joint_states', _ignore, _NEWEST)
        self._reference = self._node.create_subscription(
            JointTrajectory, '/ur5_control/reference', _ignore, _NEWEST)
        self._description = self._node.create_subscription(
            String, '/robot_description', _ignore, _LATCHED)
        self._events = self._node.create_subscription(
            DiagnosticArray, '/ur5_sim/events', _ignore, _EVENTS)
        self._newest_reference = np.full(6, np.nan)

    def description(self) -> str | None:
        """Return the robot description, if one has come since the last call."""
        message = _take(self._description)
        return None if message is None else message.data

    def sample(self) -> Sample | None:
        """Return the newest state, if one has come since the last call."""
        reference = _take(self._reference)
        if reference is not None and reference.points:
            self._newest_reference = _by_name(reference.joint_names, reference.points[0].positions)
        message = _take(self._states)
        if message is None:
            return None
        return Sample(_seconds(message), _by_name(message.name, message.position),
                      _by_name(message.name, message.effort), self._newest_reference)

    def events(self) -> Iterator[tuple[float, str, dict[str, Any]]]:
        """Yield stamp [s], kind and values of the simulator's events since the last call."""
        while (message := _take(self._events)) is not None:
            for status in message.status:
                yield _seconds(message), status.name, {
                    each.key: json.loads(each.value) for each in status.values}

    def close(self) -> None:
        """Leave the graph."""
        self._node.destroy_node()
        rclpy.try_shutdown()


def _take(subscription):
    with subscription.handle:
        taken = subscription.handle.take_message(subscription.msg_type, False)
    return None if taken is None else taken[0]


def _seconds(message) -> float:
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def _ignore(message: object) -> None:
    """Do nothing: messages are taken, not handed over."""


def _by_name(names, values) -> np.ndarray:
    """Return six values in joint order, whatever the order and prefix of the names."""
    ordered = np.full(6, np.nan)
    for name, value in zip(names, values, strict=False):
        for i, joint in enumerate(JOINT_NAMES):
            if name.endswith(joint):
                ordered[i] = value
    return ordered
