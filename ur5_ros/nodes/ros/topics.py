"""Topics of a node: how they are offered, heard and recorded."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ur5_ros.nodes.ros.executor_loop import ExecutorLoop
from ur5_ros.nodes.ros.messages import type_name
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.wait_set_loop import WaitSetLoop

#: States, commands and everything else that is published.
NEWEST = QoSProfile(depth=1)
#: /clock: losing one is harmless, the next one says more.
UNACKNOWLEDGED = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
#: What a late joiner gets too.
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
#: Events come in bursts, and none may be lost.
ALL = QoSProfile(depth=100)
#: Our own hot subscriptions: no acknowledgement travels back, which is a third of the period.
HOT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
#: Our other subscriptions.
HEARD = QoSProfile(depth=10)

Send = Callable[[bytes], None]


class Topics:
    """
    The topics of a node, each recorded as it is sent or heard.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    loop : WaitSetLoop or ExecutorLoop
        Through which the messages go.
    recording : Recording
        What they are recorded into.

    """

    def __init__(self, node: Node, loop: WaitSetLoop | ExecutorLoop, recording: Recording) -> None:
        self._node = node
        self._loop = loop
        self._recording = recording
        self.names: dict[str, str] = {}
        """Role to resolved name, for the bag's description."""
        self.heard: dict[str, tuple[str, ReliabilityPolicy]] = {}
        """Resolved name of each subscription to its type and reliability."""

    def publisher(
        self, role: str, topic: str, message_type: type, qos: QoSProfile = NEWEST,
        *, lazy: bool = False,
    ) -> tuple[Send, int]:
        """Return what publishes bytes, to somebody or at all, and the number to record them."""
        loop = self._loop
        publisher = loop.lazy_publisher if lazy else loop.publisher
        return (publisher(message_type, topic, qos),
                self._record(role, topic, message_type, qos))

    def sender(
        self, role: str, topic: str, message_type: type, qos: QoSProfile = NEWEST,
        *, lazy: bool = False,
    ) -> Send:
        """Return what publishes, to somebody or at all, and records bytes."""
        publish, number = self.publisher(
            role, topic, message_type, qos, lazy=lazy)
        recording = self._recording

        def send(data: bytes) -> None:
            publish(data)
            recording.write(number, data)

        return send

    def subscribe(
        self, role: str, topic: str, message_type: type, qos: QoSProfile = HEARD,
    ) -> tuple[int, int]:
        """Subscribe; return the number under which messages come and that to record them under."""
        record = self._record(role, topic, message_type, qos)
        self.heard[self.names[role]] = (type_name(message_type), qos.reliability)
        return self._loop.subscribe(message_type, topic, qos, hot=qos is HOT), record

    def _record(self, role: str, topic: str, message_type: type, qos: QoSProfile) -> int:
        self.names[role] = self._node.resolve_topic_name(topic)
        return self._recording.topic(
            self.names[role], type_name(message_type), _word(qos.reliability),
            _word(qos.durability), qos.depth)


def make_loop(node: Node, kind: str) -> Any:
    """Return the loop that the parameter ``hot_loop`` names."""
    return {'wait_set': WaitSetLoop, 'executor': ExecutorLoop}[kind](node)


def incompatible_publishers(node: Node, topics: Topics) -> list[tuple[str, str, str]]:
    """
    Return who publishes on a topic of ours what can never arrive.

    Returns
    -------
    list of (str, str, str)
        Topic, kind of refusal, sentence.

    """
    found = []
    for name, (wanted, reliability) in topics.heard.items():
        for each in node.get_publishers_info_by_topic(name):
            if each.topic_type != wanted:
                found.append((name, 'other type', f'{each.node_name} publishes {each.topic_type} '
                              f'there; publish {wanted}'))
            elif (reliability, each.qos_profile.reliability) == (
                    ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT):
                found.append((name, 'incompatible QoS', f'{each.node_name} publishes best effort '
                              'there; publish reliable'))
    return found


def _word(policy: Any) -> str:
    return policy.name.lower()
