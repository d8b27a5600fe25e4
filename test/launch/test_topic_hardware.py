"""A ros2_control hardware component on topics drives the arm: what the plugin sends is taken."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag
from ur5_ros.config import config_folder, load_arm
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.signals import JOINT_NAMES

PAGE = Path(__file__).resolve().parents[2] / 'docs/ros2_control.md'
TAG = ElementTree.fromstring(
    re.search(r'```xml\n(.*?)```', PAGE.read_text(encoding='utf-8'), re.DOTALL)[1])
PARAMETERS = {each.get('name'): each.text for each in TAG.iter('param')}
TORQUE = np.array([0.5, 0.0, 2.0, 0.0, 0.1, 0.0])


class Component(Node):
    """
    Publishes and subscribes as joint_state_topic_hardware_interface/JointStateTopicSystem does.

    Source: ros-controls/topic_based_hardware_interfaces, joint_state_topic_hardware_interface.cpp:
    commands QoS(1) stamped by the node's clock, states SensorDataQoS.
    """

    def __init__(self):
        super().__init__('component', start_parameter_services=False, parameter_overrides=[
            Parameter('use_sim_time', value=True)])
        self.states = 0
        self.command = self.create_publisher(
            JointState, PARAMETERS['joint_commands_topic'], QoSProfile(depth=1))
        self.create_subscription(
            JointState, PARAMETERS['joint_states_topic'], self.read, qos_profile_sensor_data)

    def read(self, _):
        self.states += 1

    def write(self):
        message = JointState(name=list(JOINT_NAMES), effort=TORQUE.tolist())
        message.header.stamp = self.get_clock().now().to_msg()
        self.command.publish(message)


def test_the_tag_of_the_page_commands_efforts_of_a_joint_of_the_arm():
    joint = TAG.find('joint')
    assert joint.get('name') in JOINT_NAMES
    assert [each.get('name') for each in joint.iter('command_interface')] == ['effort']
    assert [each.get('name') for each in joint.iter('state_interface')] == [
        'position', 'velocity', 'effort']
    assert float(PARAMETERS['trigger_joint_command_threshold']) < 0.0


def test_the_torques_of_a_topic_hardware_component_act_above_gravity(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_DOMAIN_ID', '175')
    monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE',
                       str(config_folder() / 'fastdds_loopback.xml'))
    monkeypatch.delenv('ROS_AUTOMATIC_DISCOVERY_RANGE', raising=False)
    simulator = subprocess.Popen(
        [Path(sys.executable).parent / 'sim_node', '--ros-args', '-p', 'lockstep:=false',
         '-p', 'effort_convention:=gravity_excluded', '-p', 'control_rate:=500', '-p',
         'command_timeout:=1.0', '-p', 'bag:=run'],
        cwd=tmp_path, env=dict(os.environ), stdin=subprocess.DEVNULL,
        stdout=(tmp_path / 'simulator.log').open('w'), stderr=subprocess.STDOUT)
    rclpy.init()
    node, executor = Component(), SingleThreadedExecutor()
    executor.add_node(node)
    try:
        end = time.monotonic() + 60
        while node.states < 400 and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.005)
            if node.states:
                node.write()
        assert node.states >= 400
    finally:
        simulator.send_signal(signal.SIGINT)
        simulator.wait(timeout=20)
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    states = open_bag(tmp_path / 'run').joint_states('/joint_states')
    arm = load_arm('ur5')
    # the effort of state k+1 acted from state k on, where gravity was g(q_k)
    acted = states.effort[1:] - gravity_torque(states.position[:-1], arm)
    commanded = np.abs(acted - TORQUE).max(axis=1) < 1e-6
    assert commanded.sum() > 100, (tmp_path / 'simulator.log').read_text()
    first, last = np.flatnonzero(commanded)[[0, -1]]
    assert commanded[first:last].mean() > 0.95
    assert states.velocity[:, 2].max() > 0.1, 'the elbow follows its torque'
