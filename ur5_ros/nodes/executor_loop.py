"""The plain twin of the hot loop: message objects from rclpy's own executor, the same bits."""

from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message

from ur5_ros.nodes.hot_loop import Message


class ExecutorLoop:
    """
    What :class:`~ur5_ros.nodes.hot_loop.WaitSetLoop` does, the way every rclpy program does it.

    The executor that serves the node's services takes the messages too, as objects, and hands them
    to the loop.

    Parameters
    ----------
    node : rclpy.node.Node
        The node that owns subscriptions and publishers.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._count = 0
        self._taken: SimpleQueue[Message | None] = SimpleQueue()

    def subscribe(self, message_type: type, topic: str, qos: QoSProfile) -> int:
        """Subscribe; return the number under which messages come."""
        index = self._count
        self._count += 1

        def receive(message: Any) -> None:
            self._taken.put((index, serialize_message(message)))

        self._node.create_subscription(message_type, topic, receive, qos)
        return index

    def publisher(
        self, message_type: type, topic: str, qos: QoSProfile,
    ) -> Callable[[bytes], None]:
        """Return what publishes CDR bytes on a topic, as a message object."""
        publish = self._node.create_publisher(message_type, topic, qos).publish
        return lambda data: publish(deserialize_message(data, message_type))

    def wake(self) -> None:
        """End a wait early; any thread may call it."""
        self._taken.put(None)

    def wait(self, seconds: float) -> list[Message]:
        """Wait for a message, a wake, or the time to pass; return the message if one came."""
        try:
            taken = self._taken.get(timeout=seconds)
        except Empty:
            return []
        return [] if taken is None else [taken]
