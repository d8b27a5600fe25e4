"""What both nodes send: their diagnostics, and messages under the names of the joints."""

from collections.abc import Mapping
from typing import Any

from rclpy.node import Node

from ur5_ros.cdr.diagnostics import status_array
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import Topics
from ur5_ros.signals import JOINT_NAMES


class Outputs:
    """
    The publishers of a node.

    ``kind``: what the node is, in the name of its status; ``arm_name``: ``hardware_id`` of
    everything diagnostic.

    """

    def __init__(self, node: Node, kind: str, topics: Topics, recording: Recording, prefix: str,
                 arm_name: str) -> None:
        self._status_name = f'{node.get_fully_qualified_name()}: {kind}'
        self._arm_name = arm_name
        self._recording = recording
        self._joint_names = [prefix + name for name in JOINT_NAMES]
        self._send_diagnostics = topics.sender('diagnostics')

    def diagnostics(self, stamp: int, level: int, message: str, values: Mapping[str, Any]) -> None:
        """Send a report."""
        self._send_diagnostics(status_array(
            stamp, self._status_name, message, self._arm_name, values, level))
