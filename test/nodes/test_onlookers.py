"""What only onlookers hear: the middleware is spared it until somebody does, and then never."""

import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from ros_processes import ros_domain
from rosgraph_msgs.msg import Clock

from ur5_ros.cdr.fixed_messages import encode_clock
from ur5_ros.config.topics import QUEUED
from ur5_ros.launcher.node_processes import last_core, shared_core
from ur5_ros.nodes.ros.topics import ros_profile
from ur5_ros.nodes.ros.wait_set_loop import LAZY_POLL_PERIOD, WaitSetLoop


@pytest.fixture
def nodes(tmp_path):
    with ros_domain(tmp_path) as ros:
        context = Context()
        rclpy.init(context=context, domain_id=int(ros.environment['ROS_DOMAIN_ID']))
        pair = [Node(name, context=context) for name in ('speaker', 'onlooker')]
        try:
            yield pair
        finally:
            for node in pair:
                node.destroy_node()
            rclpy.shutdown(context=context)


def test_an_onlooker_who_comes_late_misses_nothing_once_it_is_seen(nodes):
    speaker, onlooker = nodes
    publish = WaitSetLoop(speaker).lazy_publisher(Clock, '/told', ros_profile(QUEUED))
    publish(encode_clock(1))  # to nobody
    loop = WaitSetLoop(onlooker)
    loop.subscribe(Clock, '/told', ros_profile(QUEUED))
    limit = time.monotonic() + 30.0
    while not loop.take():  # until the two have found each other
        publish(encode_clock(2))
        assert time.monotonic() < limit
        time.sleep(LAZY_POLL_PERIOD)
    while loop.wait(0.2):
        pass
    heard = []
    for stamp in range(3, 303):
        publish(encode_clock(stamp))
        heard += loop.wait(5.0)
    assert heard == [(0, encode_clock(stamp)) for stamp in range(3, 303)]


def test_nodes_share_a_core_only_on_a_quiet_machine():
    assert shared_core(0.2) == str(last_core())
    assert shared_core(3.0) == ''
