"""Outputs of the simulator: states, clock, events, truth, diagnostics."""

from collections.abc import Iterable

from rclpy.node import Node

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.diagnostics import status_array
from ur5_ros.cdr.fixed_messages import FixedJointState, encode_number, encode_stamp, encode_string
from ur5_ros.cdr.layout import LITTLE_ENDIAN
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.topics import WORLD_TOPICS
from ur5_ros.nodes.ros.outputs import Outputs
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import Send, Topics
from ur5_ros.signals import ArmState
from ur5_ros.sim.events import Event
from ur5_ros.sim.plant import Plant


class SimOutputs(Outputs):
    """
    The publishers of the simulator.

    ``plant``: its world adds topics.

    """

    def __init__(
        self, node: Node, topics: Topics, recording: Recording, parameters: SimParameters,
        plant: Plant,
    ) -> None:
        super().__init__(node, 'simulator', topics, recording, parameters.tf_prefix,
                         plant.arm.name)
        self._states = FixedJointState(self._joint_names)
        self._publish_state, self._state_id = topics.publisher('joint_states')
        self._publish_clock: Send | None = None
        self._clock_id = 0
        if parameters.publish_clock:
            self._publish_clock, self._clock_id = topics.publisher('clock')
        self._send_truth = topics.sender('ground_truth')
        self._send_event = topics.sender('events')
        self._publish_run, self._run_id = topics.publisher('run')
        self._publish_rate, self._rate_id = topics.publisher('control_rate')
        self._rate = encode_number(parameters.control_rate)
        self._send_description = topics.sender('robot_description')
        self._contact: dict[str, Send] = {}
        if not plant.world.empty:
            self._contact = {topic.role: topics.sender(topic.role) for topic in WORLD_TOPICS}
        self.hash = PayloadHash(self._states)
        self._last_state = b''
        self._last_clock = b''

    def introduce(self, run: str, description: str) -> None:
        """Send the rate, the run's name and the description, for nodes that join later too."""
        self._run = encode_string(run)
        self.introduce_again()
        self._recording.write(self._rate_id, self._rate)
        self._recording.write(self._run_id, self._run)
        self._send_description(encode_string(description))

    def introduce_again(self) -> None:
        """
        Send the rate and the run's name to a controller that may have joined.

        What the middleware keeps for late subscribers may come seconds later: a short run
        is over by then.

        """
        self._publish_rate(self._rate)
        self._publish_run(self._run)

    def state(self, state: ArmState) -> None:
        """Send a new state, the clock before it."""
        stamp, write = encode_stamp(state.stamp), self._recording.write
        if self._publish_clock is not None:
            self._last_clock = LITTLE_ENDIAN + stamp
            self._publish_clock(self._last_clock)
        data = self._states.join(stamp, state.q.tobytes(), state.qd.tobytes(),
                                 state.effort.tobytes())
        self._publish_state(data)
        if self._publish_clock is not None:
            write(self._clock_id, self._last_clock)
        write(self._state_id, data)
        self._last_state = data
        self.hash.add(data)

    def state_again(self) -> None:
        """Send a copy of the last state, which is recorded already."""
        if self._publish_clock is not None:
            self._publish_clock(self._last_clock)
        self._publish_state(self._last_state)

    def truth(self, state: ArmState) -> None:
        """Send the exact state."""
        self._send_truth(self._states.encode(state.stamp, state.q, state.qd, state.effort))

    def contact(self, messages: Iterable[tuple[str, bytes]]) -> None:
        """Send what is felt of the world: role and CDR bytes of each message."""
        for role, data in messages:
            self._contact[role](data)

    def event(self, event: Event) -> None:
        """Send an event."""
        self._send_event(status_array(
            event.stamp, event.kind, event.message, self._arm_name, event.values))
