"""What the simulator hears: commands, wrenches, requests; the hostile refused."""

from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.errors import Refusal
from ur5_ros.nodes.diagnostics import Refusals
from ur5_ros.nodes.messages import EffortReader, read_message, six
from ur5_ros.nodes.recording import Recording
from ur5_ros.nodes.serving import LoopRequests
from ur5_ros.nodes.simulation import Simulation, push
from ur5_ros.nodes.topics import HOT, Topics
from ur5_ros.signals import JOINT_NAMES


class SimInputs:
    """
    The subscriptions of the simulator.

    Parameters
    ----------
    loop
        Where messages come from.
    topics : Topics
        Through which they are subscribed and recorded.
    recording : Recording
        The bag.
    simulation : Simulation
        What they act on.
    gate
        Judges commands by their stamps.
    parameters : mapping
        Of the node.

    """

    def __init__(
        self, loop: Any, topics: Topics, recording: Recording, simulation: Simulation, gate: Any,
        parameters: dict[str, Any],
    ) -> None:
        self.gate = gate
        self.command: np.ndarray | None = None
        """The command that the gate let through, until it is taken."""
        self.refusals = Refusals(simulation.logger.warning, self._tell_refusal)
        self.requests = LoopRequests(loop.wake)
        self._simulation = simulation
        self._recording = recording
        self._wait = loop.wait
        self._prefix = parameters['tf_prefix']
        names = [self._prefix + name for name in JOINT_NAMES]
        self._reader = EffortReader(names)
        self.hash = PayloadHash(self._reader.layout)
        self._last = b''
        self._names: dict[int, tuple[str, int, Any]] = {}
        for role, topic, message_type, take in (
            ('joint_command', 'joint_command', JointState, self._take_command),
            ('forward_command', 'forward_effort_controller/commands', Float64MultiArray,
             self._take_array),
            ('external_wrench', '~/external_wrench', WrenchStamped, self._take_wrench),
        ):
            number, record = topics.subscribe(role, topic, message_type, HOT)
            self._names[number] = (topics.names[role], record, take)

    def receive(self, seconds: float) -> None:
        """Wait for messages at most so long; let each do what it is for."""
        for number, data in self._wait(seconds):
            topic, record, take = self._names[number]
            try:
                take(topic, record, data)
            except Refusal as error:
                self.refusals.add(topic, 'malformed', str(error))
                self._record(record, data)
        if self.requests:
            self.requests.serve()

    def _take_command(self, topic: str, record: int, data: bytes) -> None:
        stamp, effort = self._reader.read(data)
        if self._offer(topic, stamp, effort):
            self._last = data
            self.hash.add(self._reader.layout.encode(stamp, (), (), effort))
        elif data == self._last:
            return  # a copy of what is recorded already
        self._recording.write(record, data)

    def _take_array(self, topic: str, record: int, data: bytes) -> None:
        message = read_message('std_msgs/msg/Float64MultiArray', data)
        effort = six(message['data'], 'data')
        if self._offer(topic, 0, effort):
            self.hash.add(self._reader.layout.encode(0, (), (), effort))
        self._recording.write(record, data)

    def _take_wrench(self, topic: str, record: int, data: bytes) -> None:
        message = read_message('geometry_msgs/msg/WrenchStamped', data)
        push(self._simulation.plant, message, self._prefix)
        self._recording.write(record, data)
        self._simulation.send_events()

    def _offer(self, topic: str, stamp: int, effort: np.ndarray) -> bool:
        """Return whether the gate takes a command; keep it if so."""
        refusal = self.gate.offer(stamp)
        if refusal is None:
            self.command = effort
            return True
        self.refusals.add(topic, refusal.kind, refusal.reason)
        return False

    def _record(self, record: int, data: bytes) -> None:
        """Record a refused message, unless it is large enough to hurt."""
        if len(data) <= 65_536:
            self._recording.write(record, data)

    def _tell_refusal(self, topic: str, reason: str, count: int) -> None:
        self._simulation.tell('refused', f'refused {topic}: {reason}', topic=topic, reason=reason,
                              count=count)
