"""What the controller sends: commands, references, parts of the torque, errors, poses."""

import numpy as np
from rclpy.node import Node

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.fixed_messages import (
    FixedJointState,
    FixedPose,
    FixedTrajectoryPoint,
    encode_stamp,
)
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.kernel import FEEDBACK, TOTAL
from ur5_ros.nodes.ros.outputs import Outputs
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import Topics
from ur5_ros.signals import ArmState, Reference, Torque

#: Parts of the commanded torque, as ``~/torque_parts`` names them.
PARTS = Torque._fields
_TOTAL = slice(48 * TOTAL, 48 * TOTAL + 48)


class ControlOutputs(Outputs):
    """The publishers of the controller."""

    def __init__(
        self, node: Node, topics: Topics, recording: Recording, parameters: ControlParameters,
        arm_name: str,
    ) -> None:
        prefix = parameters.tf_prefix
        super().__init__(node, 'controller', topics, recording, prefix, arm_name)
        names = self._joint_names
        self._command = FixedJointState(names, fields=('effort',))
        self._reference = FixedTrajectoryPoint(names)
        self._parts = FixedJointState(
            [f'{part}/{name}' for part in PARTS for name in names], fields=('effort',))
        self._error = FixedJointState(names, fields=('position', 'velocity'))
        self._pose = FixedPose(prefix + 'base')
        self._publish_command, self._command_id = topics.publisher('joint_command')
        self._publish_reference, self._reference_id = topics.publisher('reference')
        self._publish_parts, self._parts_id = topics.publisher('torque_parts')
        self._send_error = topics.sender('error')
        self._send_tool = topics.sender('tool_pose')
        self._send_reference_pose = topics.sender('reference_pose')
        self.hash = PayloadHash(self._command)
        self._last = b''

    def begin_run(self) -> None:
        """Hash and copy nothing of the run before."""
        self.hash = PayloadHash(self._command)
        self._last = b''

    def answer(self, stamp: int, parts: np.ndarray, reference: Reference) -> None:
        """
        Send the answer to a state; send and record what it was made of.

        ``stamp``: of the state [ns]; ``parts`` (5, 6): command and parts, as
        :class:`ur5_ros.signals.Torque` names the rows [N m].
        """
        when, torque = encode_stamp(stamp), parts.tobytes()
        write = self._recording.write
        data = self._last = self._command.join(when, b'', b'', torque[_TOTAL])
        self._publish_command(data)
        write(self._command_id, data)
        self.hash.add(data)
        q, qd, qdd = reference
        data = self._reference.join(when, q.tobytes(), qd.tobytes(), qdd.tobytes(),
                                    (parts[TOTAL] - parts[FEEDBACK]).tobytes())
        self._publish_reference(data)
        write(self._reference_id, data)
        self._last_parts = self._parts.join(when, b'', b'', torque)
        write(self._parts_id, self._last_parts)

    def command_again(self) -> None:
        """Send a copy of the last answer, which is recorded already."""
        if self._last:
            self._publish_command(self._last)

    def monitor(
        self, state: ArmState, reference: Reference,
        tool: tuple[np.ndarray, np.ndarray], desired: tuple[np.ndarray, np.ndarray],
    ) -> None:
        """
        Send what can be derived from the rest, for display.

        ``tool``, ``desired``: position (3,) [m] and quaternion (4,) as x, y, z, w of tool0 in
        base, at both.
        """
        self._publish_parts(self._last_parts)
        self._send_error(self._error.encode(
            state.stamp, state.q - reference.q, state.qd - reference.qd))
        self._send_tool(self._pose.encode(state.stamp, *tool))
        self._send_reference_pose(self._pose.encode(state.stamp, *desired))
