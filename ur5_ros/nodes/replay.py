"""A recording onto its topics: ``ur5 replay``."""

import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions

from ur5_ros.bag.playback import Playback
from ur5_ros.errors import InputError
from ur5_ros.nodes.ros.messages import message_class

#: Wall-clock time that subscribers get to find the topics before the first message [s].
DISCOVERY_TIME = 2.0
#: A subscription that is known here may not know the topic yet; after this time it does [s].
SETTLING_TIME = 0.5
#: Messages that the middleware keeps until every subscription has them.
QUEUE_DEPTH = 1000
#: Longest wait for subscriptions that do not confirm what was sent; the middleware asks the slow
#: ones again every three seconds [s].
CONFIRMATION_TIMEOUT = 4.0

#: Topics of which late joiners get the last message too.
_LATCHED_TYPES = ('std_msgs/msg/String',)


def replay(
    playback: Playback, rate: float, loop: bool,
    progress: Callable[[float], None] = lambda seconds: None,
) -> int:
    """
    Publish a recording.

    ``rate``: simulated per wall time; more than zero; ``progress``: gets the simulated time [s]
    about ten times a second.
    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Node('ur5_replay', enable_rosout=False, start_parameter_services=False)
        publishers = [_publisher(node, topic, kind) for topic, kind in playback.types.items()]
        _wait_for_subscribers(publishers)
        senders = [_Sender(publisher) for publisher in publishers]
        sent = _once(playback, senders, rate, progress)
        while loop:
            sent += _once(playback, senders, rate, progress)
        for sender in senders:
            sender.confirm()
    finally:
        rclpy.try_shutdown()
    return sent


class _Sender:
    """Publishes, and waits now and then until every subscription has what was sent."""

    def __init__(self, publisher: Publisher) -> None:
        self._publisher = publisher
        self._unconfirmed = 0
        self._confirms = True

    def __call__(self, data: bytes) -> None:
        """Publish; the middleware drops the oldest message once it keeps too many."""
        if self._unconfirmed >= QUEUE_DEPTH // 2:
            self.confirm()
        self._publisher.publish(data)
        self._unconfirmed += 1

    def confirm(self) -> None:
        """Wait until all is received; for a subscription that hangs only once."""
        if self._confirms:
            self._confirms = self._publisher.wait_for_all_acked(
                Duration(seconds=CONFIRMATION_TIMEOUT))
        self._unconfirmed = 0


def _once(playback: Playback, publish: Sequence[Callable[[bytes], None]], rate: float,
          progress: Callable[[float], None]) -> int:
    began = reported = time.monotonic()
    due = (playback.time * (1e-9 / rate)).tolist()
    topics = playback.topic.tolist()
    for i, seconds in enumerate(due):
        now = time.monotonic()
        if began + seconds > now:
            time.sleep(began + seconds - now)
        publish[topics[i]](playback.data(i))
        if now - reported > 0.1:
            reported = now
            progress(seconds * rate)
    return len(due)


def _publisher(node: Node, topic: str, kind: str) -> Publisher:
    try:
        message_type = message_class(kind)
    except (ImportError, AttributeError):
        raise InputError(f'message type {kind} of topic {topic} is not installed; leave the topic '
                         'out with --topics') from None
    latched = kind in _LATCHED_TYPES
    qos = QoSProfile(depth=QUEUE_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL if latched
                     else DurabilityPolicy.VOLATILE)
    return node.create_publisher(message_type, topic, qos)


def _wait_for_subscribers(publishers: list[Publisher]) -> None:
    end = time.monotonic() + DISCOVERY_TIME
    while time.monotonic() < end:
        if all(publisher.get_subscription_count() for publisher in publishers):
            time.sleep(SETTLING_TIME)
            return
        time.sleep(0.02)
