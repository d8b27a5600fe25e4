"""Messages in and out of the loop: raw bytes through one wait set that is kept and re-armed."""

import os
import time
from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile

from ur5_ros.errors import InputError
from ur5_ros.nodes.ros.background_executor import BackgroundExecutor

Message = tuple[int, bytes]

#: How often a lazy publisher looks for subscriptions [s].
LAZY_POLL_PERIOD = 0.02

#: While nothing but hot messages come, all else is looked after this often [s].
HOT_POLL_PERIOD = 0.01

#: After looks that cost more than they gain the loop only waits for so long: twice as long each
#: time, half as long after looks that gained [s].
SHORTEST_PAUSE, LONGEST_PAUSE = 0.001, 1.0
#: Looks between two judgements of them, and share of its core that the loop should have had.
LOOKS_PER_JUDGEMENT, SMALLEST_CORE_SHARE = 16, 0.5
#: Longest look that may be asked for [us].
MOST_SPIN = 10_000


class ReservedGroup(CallbackGroup):
    """The callback group that no executor may touch: its messages belong to the loop."""

    def can_execute(self, entity: Any) -> bool:
        """
        Return False, so that the executor leaves it alone.

        This holds for QoS events too: Fast DDS ends a wait for them with every message.

        """
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Return False, as it never may."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Do nothing."""


class WaitSetLoop:
    """
    Subscriptions and publishers of the loop, as bytes.

    The stock executor builds a wait set for each wait and hands over message objects; here one is
    kept, and the bytes go to the law and to the bag as they are.

    ``node``: the node that owns them; its other entities are left to an executor.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._group = ReservedGroup()
        self._subscriptions: list[Any] = []
        self._services: list[Any] = []
        self._background: BackgroundExecutor | None = None
        self.service_requested = False
        """Whether a watched service may have a request since the last wait."""
        self.context = node.context
        self._guard = node.create_guard_condition(_nothing, self._group)
        self._wait_set: Any = None
        self._hot: list[int] = []
        self._brief_until = 0.0
        self._spin = spin_time()
        self._spin_from = 0.0
        self._pause = SHORTEST_PAUSE
        self._looks = 0
        self._since = self._used = 0.0

    def subscribe(self, message_type: type, topic: str, qos: QoSProfile,
                  *, hot: bool = False) -> int:
        """
        Subscribe, before the first wait; return the number under which messages come.

        Hot is what comes every period; all else waits for :data:`HOT_POLL_PERIOD` at most.
        """
        if hot:
            self._hot.append(len(self._subscriptions))
        self._subscriptions.append(self._node.create_subscription(
            message_type, topic, _nothing, qos, callback_group=self._group, raw=True))
        return len(self._subscriptions) - 1

    def publisher(
        self, message_type: type, topic: str, qos: QoSProfile,
    ) -> Callable[[bytes], None]:
        """Return what publishes CDR bytes on a topic."""
        return self._node.create_publisher(message_type, topic, qos).handle.publish_raw

    def lazy_publisher(
        self, message_type: type, topic: str, qos: QoSProfile,
    ) -> Callable[[bytes], None]:
        """Return the same for what may have no subscription: the middleware is then spared it."""
        handle = self._node.create_publisher(message_type, topic, qos).handle
        publish, count, now = handle.publish_raw, handle.get_subscription_count, time.monotonic
        subscribed, due = False, 0.0

        def publish_if_subscribed(data: bytes) -> None:
            nonlocal subscribed, due
            if now() >= due:
                subscribed, due = count() > 0, now() + LAZY_POLL_PERIOD
            if subscribed:
                publish(data)

        return publish_if_subscribed

    def watch_service(self, service: Any) -> None:
        """Let a request to a service, which no executor serves, end a wait."""
        self._services.append(service)

    def start(self) -> None:
        """Begin to serve everything else of the node, in a thread."""
        self._background = BackgroundExecutor(self._node)

    def close(self) -> None:
        """Serve no more."""
        if self._background is not None:
            self._background.close()

    def wake(self) -> None:
        """End a wait early; any thread may call it."""
        self._guard.trigger()

    def wait(self, seconds: float) -> list[Message]:
        """
        Wait for messages, a wake, or the time; :data:`HOT_POLL_PERIOD` while hot messages flow.

        ``seconds``: longest wait of wall time; 0 = none: what has come is taken.  Returned: at
        most one message of each subscription that has any; the next wait returns at once if there
        are more of the hot ones.
        """
        wait_set = self._wait_set or self._arm()
        if seconds <= 0.0:
            return self.take()
        now = time.monotonic()
        rest = self._brief_until - now
        if rest > 0.0:
            if self._spin and now >= self._spin_from:
                messages = self._look(now)
                if messages:
                    return messages
            return self._wait_briefly(min(seconds, rest))
        wait_set.clear_entities()
        for handle in self._handles:
            wait_set.add_subscription(handle)
        for handle in self._service_handles:
            wait_set.add_service(handle)
        wait_set.add_guard_condition(self._guard_handle)
        wait_set.wait(int(seconds * 1e9))
        self.service_requested = any(wait_set.is_ready('service', index)
                                     for index in range(len(self._service_handles)))
        messages = []
        for index in self._indices:
            if wait_set.is_ready('subscription', index):
                taken = self._takes[index](self._types[index], True)
                if taken is not None:
                    messages.append((index, taken[0]))
        if messages and not self.service_requested and all(
                index in self._hot for index, _ in messages):
            self._brief_until = time.monotonic() + HOT_POLL_PERIOD
        return messages

    def _look(self, now: float) -> list[Message]:
        """
        Look for hot messages again and again for a while, without a wait.

        The middleware's own threads have this core in between.  Looking costs more than waiting
        where the answer takes long, and where others use the core: who sleeps is served first.
        """
        if self._looks == 0:
            self._since, self._used = now, time.thread_time()
        end = now + self._spin
        while True:
            messages = self._take(self._hot)
            now = time.monotonic()
            if messages or now > end:
                break
            os.sched_yield()
        self._looks += 1
        if now > end or self._looks >= LOOKS_PER_JUDGEMENT:
            self._judge_looks(now, vain=now > end)
        return messages

    def _judge_looks(self, now: float, vain: bool) -> None:
        """Look on, or pause."""
        self._looks = 0
        if vain or time.thread_time() - self._used < SMALLEST_CORE_SHARE * (now - self._since):
            self._pause = min(2.0 * self._pause, LONGEST_PAUSE)
            self._spin_from = now + self._pause
        else:
            self._pause = max(0.5 * self._pause, SHORTEST_PAUSE)

    def _wait_briefly(self, seconds: float) -> list[Message]:
        """Wait for hot messages alone: every place in a wait set costs the loop microseconds."""
        wait_set = self._hot_wait_set
        wait_set.clear_entities()
        for handle in self._hot_handles:
            wait_set.add_subscription(handle)
        wait_set.wait(int(seconds * 1e9))
        return self._take(self._hot)

    def take(self) -> list[Message]:
        """Return at most one message of each subscription, without a wait."""
        self.service_requested = True
        if self._wait_set is None:
            self._arm()
        return self._take(self._indices)

    def _take(self, indices: list[int]) -> list[Message]:
        messages = []
        for index in indices:
            taken = self._takes[index](self._types[index], True)
            if taken is not None:
                messages.append((index, taken[0]))
        return messages

    def _arm(self) -> Any:
        self._handles = [each.handle for each in self._subscriptions]
        self._takes = [each.take_message for each in self._handles]
        self._types = [each.msg_type for each in self._subscriptions]
        self._indices = list(range(len(self._handles)))
        self._hot_handles = [self._handles[index] for index in self._hot]
        self._service_handles = [each.handle for each in self._services]
        self._guard_handle = self._guard.handle
        context = self._node.context.handle
        self._hot_wait_set = _rclpy.WaitSet(len(self._hot), 0, 0, 0, 0, 0, context)
        self._wait_set = _rclpy.WaitSet(
            len(self._handles), 1, 0, 0, len(self._services), 0, context)
        return self._wait_set


def spin_time() -> float:
    """Return how long a loop looks for messages before it waits, by the environment [s]."""
    text = os.environ.get('UR5_ROS_SPIN', '') or '0'
    if not (text.isascii() and text.isdigit() and int(text) <= MOST_SPIN):
        raise InputError(f'UR5_ROS_SPIN is {text!r}; give whole microseconds from 0 to '
                         f'{MOST_SPIN}, or unset it')
    return 1e-6 * int(text)


def _nothing(*_: Any) -> None:
    """Take the place of a callback that is never called."""
