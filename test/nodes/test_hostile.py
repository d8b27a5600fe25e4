"""Bytes that are no messages, messages that are too large, and too many: the nodes live on."""

import random

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, WrenchStamped
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ur5_ros.config.parameters import HOME
from ur5_ros.signals import JOINT_NAMES

MUTANTS = 150


def samples():
    """Return a message to be spoilt for each input topic of each node."""
    state = JointState(name=list(JOINT_NAMES), position=HOME, velocity=[0.0] * 6,
                       effort=[0.0] * 6)
    point = JointTrajectoryPoint(positions=HOME)
    return {
        'sim': {
            '/joint_command': state,
            '/forward_effort_controller/commands': Float64MultiArray(data=[0.0] * 6),
            '/ur5_sim/external_wrench': WrenchStamped(),
        },
        'control': {
            '/joint_states': state,
            '/ur5_sim/run': String(data='a run'),
            '/ur5_control/target_joints': state,
            '/ur5_control/target_pose': PoseStamped(),
            '/ur5_control/joint_trajectory': JointTrajectory(joint_names=list(JOINT_NAMES),
                                                             points=[point]),
            '/ur5_control/path': Path(poses=[PoseStamped()]),
        },
    }


def spoilt(data: bytes, chance: random.Random) -> bytes:
    """Return the bytes of a message cut, stretched, flipped or replaced."""
    kind = chance.randrange(4)
    if kind == 0:
        return data[:chance.randrange(4, len(data))]
    if kind == 1:
        return data + chance.randbytes(chance.randrange(1, 64))
    if kind == 2:
        return data[:4] + chance.randbytes(len(data) - 4)
    place = chance.randrange(4, len(data) - 4)
    return data[:place] + b'\xff\xff\xff\x7f' + data[place + 4:]


@pytest.fixture
def loop(ros):
    """Both nodes running, and the newest states."""
    ros.watcher = ros.observer()
    ros.control = ros.start('control', bag='')
    ros.sim = ros.start('sim', bag='')
    ros.states = ros.watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: len(ros.states) > 10, 'a running loop')
    return ros


def lives_on(ros):
    """Check that the loop runs and both nodes end in order."""
    newest = max(message.header.stamp.sec for message in ros.states[-50:])
    count = len(ros.states)
    wait_until(lambda: len(ros.states) > count + 100, f'states after {newest} s')
    for node in (ros.control, ros.sim):
        assert node.stop() == 0, node.text
        assert 'Traceback' not in node.text, node.text


@pytest.mark.parametrize('node', ['sim', 'control'])
def test_damaged_bytes_end_no_node(loop, node):
    chance = random.Random(node)
    for topic, sample in samples()[node].items():
        publisher = loop.watcher.publisher(type(sample), topic, kept=topic.endswith('run'))
        data = bytes(serialize_message(sample))
        for _ in range(MUTANTS):
            publisher.publish(spoilt(data, chance))
    lives_on(loop)


def test_messages_of_two_million_names_are_passed_over(loop):
    huge = bytes(4) + np.random.default_rng(1).bytes(16_000_000)
    for topic in ('/joint_command', '/joint_states', '/ur5_control/target_joints'):
        publisher = loop.watcher.publisher(JointState, topic)
        for _ in range(2):
            publisher.publish(huge)
    lives_on(loop)


def test_a_flood_of_commands_stops_nothing(loop):
    publisher = loop.watcher.publisher(JointState, '/joint_command')
    flood = JointState(name=list(JOINT_NAMES), effort=[1e30] * 6)
    flood.header.stamp.sec = 1_000_000
    for _ in range(20_000):
        publisher.publish(flood)
    lives_on(loop)
