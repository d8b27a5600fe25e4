"""The loop with rclpy's own executor and message objects; the same bits."""

import traceback
from collections.abc import Callable
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from ur5_ros.cdr.codec import encode
from ur5_ros.nodes.ros.messages import type_name
from ur5_ros.nodes.ros.wait_set_loop import Message


class ExecutorLoop:
    """
    The loop of every rclpy program, in place of :class:`.wait_set_loop.WaitSetLoop`.

    One executor in the loop's own thread takes messages, as objects, and serves the services.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._count = 0
        self._taken: list[Message] = []
        self.service_requested = True
        """Whether a watched service may have a request: always, as this loop does not know."""
        self._executor = SingleThreadedExecutor(context=node.context)

    def subscribe(self, message_type: type, topic: str, qos: QoSProfile,
                  *, hot: bool = False) -> int:
        """Subscribe; return the number under which messages come."""
        index = self._count
        self._count += 1
        name = type_name(message_type)

        def receive(message: Any) -> None:
            self._taken.append((index, encode(name, plain(message))))

        self._node.create_subscription(message_type, topic, receive, qos)
        return index

    def publisher(
        self, message_type: type, topic: str, qos: QoSProfile,
    ) -> Callable[[bytes], None]:
        """Return what publishes CDR bytes on a topic, as a message object."""
        publish = self._node.create_publisher(message_type, topic, qos).publish
        return lambda data: publish(deserialize_message(data, message_type))

    lazy_publisher = publisher

    def watch_service(self, service: Any) -> None:
        """Do nothing: the loop looks after each wait whether a request has come."""

    def start(self) -> None:
        """Begin to take messages and to serve."""
        self._executor.add_node(self._node)

    def wake(self) -> None:
        """End a wait early; any thread may call it."""
        self._executor.wake()

    def wait(self, seconds: float) -> list[Message]:
        """Wait for a message, a request, a wake, or the time to pass; return what came."""
        try:
            self._executor.spin_once(timeout_sec=seconds)
        except ExternalShutdownException:
            raise
        except Exception:  # a callback's error must not end the others
            traceback.print_exc()
        messages, self._taken = self._taken, []
        return messages

    def take(self) -> list[Message]:
        """Return what has come, without a wait."""
        return self.wait(0.0)

    def close(self) -> None:
        """Serve no more."""
        self._executor.remove_node(self._node)


def plain(message: Any) -> Any:
    """
    Return a message object as nested dicts.

    rclpy's ``serialize_message`` is no way to its bytes: it appends up to a dozen that are not the
    message's, and leaves padding as it was in memory.

    """
    if hasattr(message, 'get_fields_and_field_types'):
        return {name: plain(getattr(message, name))
                for name in message.get_fields_and_field_types()}
    if isinstance(message, list):
        return [plain(item) for item in message]
    return message
