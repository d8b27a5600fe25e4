"""What only onlookers hear: the middleware is spared it until somebody does, and then never."""

import os
import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from ros_processes import ros_domain
from rosgraph_msgs.msg import Clock

from ur5_ros.cdr.fixed_messages import encode_clock
from ur5_ros.config.topics import HOT, QUEUED
from ur5_ros.launcher.node_processes import lockstep_cores
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


def expect_every_message(publish, loop):
    """Send three hundred messages, once nothing is under way; each has to come, in order."""
    while loop.wait(0.2):
        pass
    received = []
    for stamp in range(3, 303):
        publish(encode_clock(stamp))
        received += loop.wait(5.0)
    assert received == [(0, encode_clock(stamp)) for stamp in range(3, 303)]


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
    expect_every_message(publish, loop)


@pytest.mark.parametrize('microseconds', ['', '5000'])
def test_a_loop_that_looks_before_it_waits_hears_the_same(nodes, monkeypatch, microseconds):
    speaker, listener = nodes
    monkeypatch.setenv('UR5_ROS_SPIN', microseconds)
    publish = WaitSetLoop(speaker).publisher(Clock, '/told', ros_profile(QUEUED))
    loop = WaitSetLoop(listener)
    loop.subscribe(Clock, '/told', ros_profile(HOT), hot=True)
    limit = time.monotonic() + 30.0
    while not loop.wait(0.1):
        publish(encode_clock(1))
        assert time.monotonic() < limit
    expect_every_message(publish, loop)
    monkeypatch.setattr('ur5_ros.nodes.ros.wait_set_loop.HOT_POLL_PERIOD', 60.0)
    publish(encode_clock(303))
    assert loop.wait(5.0)
    began = time.thread_time()
    assert [loop.wait(0.009) for _ in range(20)] == [[]] * 20
    assert time.thread_time() - began < 0.05, 'it looks in vain less and less'


def test_nodes_are_bound_to_cores_only_on_a_quiet_machine(monkeypatch):
    cores = sorted(os.sched_getaffinity(0))
    bound = lockstep_cores(0.2)
    if len(cores) > 1:
        assert [each['UR5_ROS_CORE'] for each in bound] == [str(each) for each in cores[-2:]]
        assert all(int(each['UR5_ROS_SPIN']) > 0 for each in bound)
    monkeypatch.setattr(os, 'sched_getaffinity', lambda pid: {cores[0]})
    assert lockstep_cores(0.2) == [{'UR5_ROS_CORE': str(cores[0])}] * 2, 'nothing to look for'
    assert lockstep_cores(3.0) == [{'UR5_ROS_CORE': ''}] * 2
