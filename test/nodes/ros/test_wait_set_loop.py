"""The loop's wait: hot messages first, all else soon after, nothing passed over."""

import threading
import time

import pytest
from geometry_msgs.msg import WrenchStamped
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from ur5_ros.cdr.codec import decode
from ur5_ros.nodes.ros.wait_set_loop import HOT_POLL_PERIOD, WaitSetLoop

QOS = QoSProfile(depth=10)
TOPICS = {'hot': JointState, 'cold': WrenchStamped, 'other': String}


@pytest.fixture
def received(ros):
    """A loop that hears three topics, the numbers it knows them by, and who publishes there."""
    loop, talker = WaitSetLoop(ros.observer('listener').node), ros.observer('talker')
    numbers = {topic: loop.subscribe(kind, topic, QOS, hot=topic == 'hot')
               for topic, kind in TOPICS.items()}
    yield loop, numbers, {topic: talker.publisher(kind, topic).publish
                          for topic, kind in TOPICS.items()}


def test_what_comes_now_and_then_is_heard_while_hot_messages_never_pause(received):
    loop, numbers, publish = received
    wrench, found, hot = WrenchStamped(), [], 0
    limit = time.monotonic() + 30.0
    for turn in range(1, 1_000_000):
        publish['hot'](JointState(name=['a'], position=[1.0]))
        if turn % 200 == 0:
            wrench.wrench.force.x = float(turn)
            publish['cold'](wrench)
        for number, data in loop.wait(1.0):
            assert number in (numbers['hot'], numbers['cold'])
            if number == numbers['hot']:
                hot += 1
            else:
                found.append(decode('geometry_msgs/msg/WrenchStamped', data)['wrench']['force'])
        if len(found) == 5 or time.monotonic() > limit:
            break
    assert [force['x'] for force in found] == [200.0, 400.0, 600.0, 800.0, 1000.0]
    assert hot >= 900


def test_every_one_of_a_burst_is_handed_over_in_order(received):
    loop, numbers, publish = received
    publish['hot'](JointState())
    assert loop.wait(5.0)  # from here on the loop counts as running
    for text in 'abcdefgh':
        publish['other'](String(data=text))
    found = []
    limit = time.monotonic() + 30.0
    while len(found) < 8 and time.monotonic() < limit:
        found += [decode('std_msgs/msg/String', data)['data'] for number, data in loop.wait(0.05)
                  if number == numbers['other']]
    assert ''.join(found) == 'abcdefgh'


def test_a_wake_ends_a_wait_of_either_kind(received):
    loop, _, publish = received
    for before in ([], ['hot']):
        time.sleep(2 * HOT_POLL_PERIOD)
        for topic in before:
            publish[topic](JointState())
            assert loop.wait(5.0)
        waker = threading.Timer(0.2, loop.wake)
        waker.start()
        begin = time.monotonic()
        while waker.is_alive():  # a brief wait ends by itself
            loop.wait(60.0)
        waker.join()
        assert time.monotonic() - begin < 30.0
