"""Inputs of the simulator: commands, wrenches, requests; what is malformed is refused."""

from typing import Any

import numpy as np

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.decoded import force_and_torque
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.frames import wrench_in_base
from ur5_ros.nodes.ros.background_executor import LoopRequests
from ur5_ros.nodes.ros.messages import MOST_RECORDED, EffortReader, read_message
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import Loop, Topics
from ur5_ros.nodes.sim.services import StepQueue
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.command_gate import CommandGate
from ur5_ros.throttle import RefusalCount


class SimInputs:
    """The subscriptions of the simulator, and the requests of its services."""

    def __init__(
        self, loop: Loop, topics: Topics, recording: Recording, simulation: Simulation,
        gate: CommandGate, steps: StepQueue, parameters: SimParameters,
    ) -> None:
        self.refusals = RefusalCount()
        self.requests = LoopRequests(loop.wake)
        self.last_was_stamped = False
        """Whether the last command taken named its state, so that a copy does no harm."""
        self.command_topics: list[str] = []
        self.copies = 0
        """Copies of the last command taken that were passed over."""
        self._simulation = simulation
        self._recording = recording
        self._gate = gate
        self._steps = steps
        self._loop = loop
        self._prefix = parameters.tf_prefix
        self._reader = EffortReader([self._prefix + name for name in JOINT_NAMES])
        self.hash = PayloadHash(self._reader.layout)
        self._last = b''
        self._subscriptions: dict[int, tuple[str, int, Any]] = {}
        inputs = [('joint_command', self._take_command), ('external_wrench', self._take_wrench)]
        if parameters.forward_commands:
            inputs.insert(1, ('forward_command', self._take_array))
        for role, take in inputs:
            number, record = topics.subscribe(role)
            self._subscriptions[number] = (topics.names[role], record, take)
            if 'command' in role:
                self.command_topics.append(topics.names[role])

    def receive(self, seconds: float) -> bool:
        """Wait at most so long, do what has come, and return whether a message has."""
        messages = self._loop.wait(seconds)
        for number, data in messages:
            self._dispatch(number, data)
        if self.requests:
            self.requests.serve()
        if self._loop.service_requested and self._steps.update(self._simulation):
            self._gate.resumed()
        return bool(messages)

    def refuse(self, topic: str, kind: str, reason: str) -> None:
        """Count what is refused, and report it now and then."""
        if count := self.refusals.add(topic, kind):
            self._simulation.log('refused', f'{topic}: refused: {reason} ({count} so far)',
                                 topic=topic, reason=reason, count=count)

    def answer_step(self) -> None:
        """Answer ``~/step``, if a period was taken for it."""
        if self._steps and self._simulation.paused:
            self._steps.answer(self._simulation)

    def _dispatch(self, number: int, data: bytes) -> None:
        topic, record, take = self._subscriptions[number]
        try:
            take(topic, record, data)
        except InputError as error:
            self.refuse(topic, 'malformed', str(error))
            if len(data) <= MOST_RECORDED:
                self._recording.write(record, data)

    def _take_command(self, topic: str, record: int, data: bytes) -> None:
        if data == self._last:
            self.copies += 1  # of an answer that is recorded and counted already
            return
        stamp, names, effort = self._reader.read(data)
        if names is None:
            refused = self._gate.offer(topic, stamp, effort)
        else:
            refused = self._gate.offer_by_name(topic, stamp, names, effort)
        if refused is None:
            self._taken(stamp, names, effort, data)
            if stamp:
                self._last = data
        self._recording.write(record, data)

    def _take_array(self, topic: str, record: int, data: bytes) -> None:
        effort = read_message('std_msgs/msg/Float64MultiArray', data)['data']
        if self._gate.offer(topic, 0, effort) is None:
            self._taken(0, None, effort)
        self._recording.write(record, data)

    def _taken(self, stamp: int, names: Any, effort: Any, data: bytes = b'') -> None:
        self.last_was_stamped = stamp != 0
        if self.hash.count == 0:
            self._simulation.outputs.introduce_again()
        if names is None and len(data) == self._reader.layout.size:
            self.hash.add(data)  # laid out as what is hashed
            return
        if names is not None:
            place = dict(zip(names, effort, strict=True))
            effort = [place[name] for name in self._reader.names]
        self.hash.add(self._reader.layout.encode(stamp, (), (), np.asarray(effort, float)))

    def _take_wrench(self, topic: str, record: int, data: bytes) -> None:
        message = read_message('geometry_msgs/msg/WrenchStamped', data)
        plant, (force, torque) = self._simulation.plant, force_and_torque(message['wrench'])
        wrench = wrench_in_base(force, torque, message['header']['frame_id'], plant.truth.q,
                                plant.arm, self._prefix)
        plant.apply_wrench(wrench[:3].tolist(), wrench[3:].tolist())
        self._recording.write(record, data)
        self._simulation.send_events(self._simulation.plant)

