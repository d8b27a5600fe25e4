"""Topics of a node, published, subscribed to and recorded as they are declared."""

from collections.abc import Callable, Iterable

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ur5_ros.config.topics import HOT, Qos, Topic, by_role
from ur5_ros.nodes.ros.executor_loop import ExecutorLoop
from ur5_ros.nodes.ros.messages import message_class
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.wait_set_loop import WaitSetLoop

Send = Callable[[bytes], None]
#: The loop of a node.
Loop = WaitSetLoop | ExecutorLoop


class Topics:
    """The topics of a node, each recorded as it is sent or received."""

    def __init__(self, node: Node, loop: Loop, recording: Recording,
                 declared: Iterable[Topic]) -> None:
        self._node = node
        self._loop = loop
        self._recording = recording
        self._declared = by_role(declared)
        self.names: dict[str, str] = {}
        """Role to resolved name, for the bag's description."""
        self.subscribed: dict[str, Topic] = {}
        """Resolved name of each subscription to its topic."""

    def publisher(self, role: str) -> tuple[Send, int]:
        """Return what publishes the bytes of a topic, and the number to record them under."""
        topic = self._declared[role]
        publisher = self._loop.lazy_publisher if topic.lazy else self._loop.publisher
        return (publisher(message_class(topic.type), topic.name, ros_profile(topic.qos)),
                self._record(topic))

    def sender(self, role: str) -> Send:
        """Return what publishes and records the bytes of a topic."""
        publish, number = self.publisher(role)
        recording = self._recording

        def send(data: bytes) -> None:
            publish(data)
            recording.write(number, data)

        return send

    def subscribe(self, role: str) -> tuple[int, int]:
        """Subscribe; return the number under which messages come and that to record them under."""
        topic = self._declared[role]
        record = self._record(topic)
        self.subscribed[self.names[role]] = topic
        return self._loop.subscribe(message_class(topic.type), topic.name,
                                    ros_profile(topic.qos), hot=topic.qos == HOT), record

    def _record(self, topic: Topic) -> int:
        self.names[topic.role] = self._node.resolve_topic_name(topic.name)
        return self._recording.topic(self.names[topic.role], topic.type, topic.qos)


def make_loop(node: Node, kind: str) -> Loop:
    """Return the loop of a node that has a thread for itself: ``hot_loop`` names it."""
    return WaitSetLoop(node) if kind == 'wait_set' else ExecutorLoop(node)


def publishing_nodes(node: Node, topic: str) -> list[str]:
    """Return the full names of the nodes that publish on a topic."""
    return [f'{each.node_namespace.rstrip("/")}/{each.node_name}'
            for each in node.get_publishers_info_by_topic(topic)]


def incompatible_publishers(node: Node, topics: Topics) -> list[tuple[str, str, str]]:
    """Return the publishers on subscribed topics whose messages can never arrive."""
    found = []
    for name, topic in topics.subscribed.items():
        for each in node.get_publishers_info_by_topic(name):
            if each.topic_type != topic.type:
                found.append((name, 'other type', f'{each.node_name} publishes {each.topic_type} '
                              f'there; publish {topic.type}'))
            elif (topic.qos.reliability == 'reliable'
                  and each.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT):
                found.append((name, 'incompatible QoS', f'{each.node_name} publishes best effort '
                              'there; publish reliable'))
    return found


def ros_profile(qos: Qos) -> QoSProfile:
    """Return a declared quality of service as rclpy has it."""
    return QoSProfile(depth=qos.depth, reliability=ReliabilityPolicy[qos.reliability.upper()],
                      durability=DurabilityPolicy[qos.durability.upper()])
