"""The loops of several nodes in one thread: each takes what has come, one wait serves all."""

import time
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node

from ur5_ros.nodes.ros.wait_set_loop import HOT_POLL_PERIOD, Message, WaitSetLoop


class SharedLoop(WaitSetLoop):
    """
    The loop of one node that takes turns with others: it takes messages and does not wait.

    Fast DDS hands a message over inside a process before ``publish`` returns, so that a take finds
    what the other node has just sent.

    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.wake_at = 0.0
        """Steady time at which the node has to have its next turn [s]."""
        self._take_all_at = 0.0

    def wait(self, seconds: float) -> list[Message]:
        """Return the messages that are there; the wait itself is left to :class:`SharedWait`."""
        now = time.monotonic()
        self.wake_at = now + seconds
        if now >= self._take_all_at:
            self._take_all_at = now + HOT_POLL_PERIOD
            return self.take()
        self.service_requested = False
        return self._take(self._hot)

    def take_all_next(self) -> None:
        """Let the next turn look at every subscription and service."""
        self._take_all_at = 0.0

    def entities(self) -> tuple[list[Any], list[Any], Any]:
        """Return the handles of subscriptions and services, and the guard condition's."""
        if self._wait_set is None:
            self._arm()
        return self._handles, self._service_handles, self._guard_handle


class SharedWait:
    """One wait for everything that any of the loops could receive."""

    def __init__(self) -> None:
        self._loops: list[SharedLoop] = []
        self._wait_set: Any = None

    def loop(self, node: Node) -> SharedLoop:
        """Return the loop of one more node; to be called before the first wait."""
        self._loops.append(SharedLoop(node))
        return self._loops[-1]

    def wait(self) -> None:
        """Wait for a message, a request or a wake, until the first loop has to have its turn."""
        seconds = min(loop.wake_at for loop in self._loops) - time.monotonic()
        if seconds <= 0.0:
            return
        entities = [loop.entities() for loop in self._loops]
        if self._wait_set is None:
            counts = [sum(len(each[kind]) for each in entities) for kind in (0, 1)]
            context = self._loops[0].context
            self._wait_set = _rclpy.WaitSet(
                counts[0], len(entities), 0, 0, counts[1], 0, context.handle)
        self._wait_set.clear_entities()
        for subscriptions, services, guard in entities:
            for handle in subscriptions:
                self._wait_set.add_subscription(handle)
            for handle in services:
                self._wait_set.add_service(handle)
            self._wait_set.add_guard_condition(guard)
        self._wait_set.wait(int(seconds * 1e9))
        for loop in self._loops:
            loop.take_all_next()
