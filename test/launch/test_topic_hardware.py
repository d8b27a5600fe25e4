"""A ros2_control hardware component on topics drives the arm: what the plugin sends is taken."""

import importlib.util
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import rclpy
import yaml
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.reader import open_bag
from ur5_ros.config import config_folder, load_arm
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.signals import JOINT_NAMES, stamp_of_period
from ur5_ros.sim.lockstep_gate import command_gate
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.sim.urdf_ros2_control import with_ros2_control

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

    def write(self, torque):
        message = JointState(name=list(JOINT_NAMES), effort=torque.tolist())
        message.header.stamp = self.get_clock().now().to_msg()
        self.command.publish(message)


def test_the_tag_of_the_page_commands_efforts_of_a_joint_of_the_arm():
    joint = TAG.find('joint')
    assert joint.get('name') in JOINT_NAMES
    assert [each.get('name') for each in joint.iter('command_interface')] == ['effort']
    assert [each.get('name') for each in joint.iter('state_interface')] == [
        'position', 'velocity', 'effort']
    assert float(PARAMETERS['trigger_joint_command_threshold']) < 0.0


def drive(monkeypatch, tmp_path, torque, every):
    """Command a paced simulator at a rate of the component's own, for 400 states."""
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
        end, due = time.monotonic() + 60, 0.0
        while node.states < 400 and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.005)
            if node.states and time.monotonic() > due:
                due = time.monotonic() + every
                node.write(torque)
        assert node.states >= 400
    finally:
        simulator.send_signal(signal.SIGINT)
        simulator.wait(timeout=20)
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def test_the_torques_of_a_topic_hardware_component_act_above_gravity(monkeypatch, tmp_path):
    drive(monkeypatch, tmp_path, TORQUE, 0.0)
    states = open_bag(tmp_path / 'run').joint_states('/joint_states')
    arm = load_arm('ur5')
    # the effort of state k+1 acted from state k on, where gravity was g(q_k)
    acted = states.effort[1:] - gravity_torque(states.position[:-1], arm)
    commanded = np.abs(acted - TORQUE).max(axis=1) < 1e-6
    assert commanded.sum() > 100, (tmp_path / 'simulator.log').read_text()
    first, last = np.flatnonzero(commanded)[[0, -1]]
    assert commanded[first:last].mean() > 0.95
    assert states.velocity[:, 2].max() > 0.1, 'the elbow follows its torque'


def test_a_run_whose_commands_come_at_their_own_rate_is_judged_by_what_held(monkeypatch, tmp_path):
    drive(monkeypatch, tmp_path, TORQUE * [1, 0, 0, 0, 0, 0], 0.011)
    result = validate(load_run(tmp_path / 'run'))
    for name in ('pairing', 'command acts'):
        assert result.check(name).verdict == 'pass', result.check(name).sentence
    pairing = result.check('pairing')
    assert 'at their own rate' in pairing.sentence
    assert pairing.details['commands_held'] < 0.5 * pairing.details['answered']


def test_the_command_prints_the_tag_for_every_joint():
    for prefix in ('', 'left_'):
        text = with_ros2_control(urdf_text(load_arm('ur5e'), prefix), prefix)
        [tag] = ElementTree.fromstring(text).iter('ros2_control')
        assert [joint.get('name') for joint in tag.iter('joint')] == [
            prefix + name for name in JOINT_NAMES]
        assert {each.get('name') for each in tag.iter('command_interface')} == {'effort'}
        page = {each.tag: each.text for each in TAG.find('hardware') if each.text}
        assert {each.text for each in tag.find('hardware')} == {
            each.text for each in TAG.find('hardware')}, page
    printed = subprocess.run(
        [Path(sys.executable).parent / 'ur5', 'urdf', '--arm', 'ur5e', '--ros2-control'],
        capture_output=True, text=True, check=True).stdout
    assert with_ros2_control(urdf_text(load_arm('ur5e'))).rstrip() == printed.rstrip()


def gate(**parameters):
    return command_gate(JOINT_NAMES, SimParameters.of(
        {'lockstep': False, 'control_rate': 500, 'physics_rate': 1000} | parameters),
        time.monotonic)


def test_six_nan_are_no_command_and_no_refusal():
    paced = gate()
    assert paced.offer('/joint_command', 2_000_000, [float('nan')] * 6) is not None
    assert paced.empty == 1 and not paced.refused and not paced.drain_events()
    assert paced.next().command is None
    assert paced.offer('/joint_command', 2_000_000, [0.0] * 5 + [float('nan')]) is not None
    assert paced.refused, 'one NaN among torques is a mistake'


@pytest.mark.parametrize(('timeout', 'acts'), [(0.0, True), (0.1, False)])
def test_a_torque_that_never_changes_is_no_command_after_a_time(timeout, acts):
    """The plugin goes on sending the last torque of a controller that was deactivated."""
    paced = gate(repeated_command_timeout=timeout, realtime_factor=0.0)
    for k in range(1, 200):
        paced.published(k)
        paced.offer('/joint_command', stamp_of_period(k, 500), TORQUE)
        decision = paced.next()
        assert decision.step
        if k < 50:
            assert decision.command is not None
    assert (decision.command is not None) == acts
    paced.published(200)
    assert paced.offer('/joint_command', stamp_of_period(200, 500), TORQUE + 1e-9) is None
    assert paced.next().command is not None, 'a controller that is back is heard'


def test_the_shipped_gains_bring_the_arm_to_a_goal_through_held_torques():
    """As the joint_trajectory_controller does it: PID on effort, 500 times a second."""
    file = yaml.safe_load((config_folder() / 'controllers.yaml').read_text(encoding='utf-8'))
    gains = file['arm_trajectory_controller']['ros__parameters']['gains']
    assert list(gains) == list(JOINT_NAMES)
    p, i, d = (np.array([each[name] for each in gains.values()]) for name in 'pid')
    lower, upper = (np.array([each[f'i_clamp_{end}'] for each in gains.values()])
                    for end in ('min', 'max'))
    plant = Plant(load_arm('ur5'), {'control_rate': 500, 'physics_rate': 1000,
                                    'effort_convention': 'gravity_excluded'})
    start, integral = plant.state.q, np.zeros(6)
    goal = start + [0.3, -0.2, 0.3, 0.2, -0.3, 0.5]
    for k in range(3000):
        s = min(k / 1500, 1.0)
        share, rate = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s)**2 / 3.0
        error = start + share * (goal - start) - plant.state.q
        integral = np.clip(integral + i * error / 500, lower, upper)
        plant.step(p * error + integral + d * (rate * (goal - start) - plant.state.qd))
    plant.close()
    assert np.abs(plant.state.q - goal).max() < 0.02
    assert np.abs(plant.state.qd).max() < 0.01


def test_the_launch_file_keeps_the_two_descriptions_and_the_names_apart(monkeypatch, tmp_path):
    index = tmp_path / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    for package in ('robot_state_publisher', 'controller_manager',
                    'joint_state_topic_hardware_interface'):
        (index / package).touch()
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    spec = importlib.util.spec_from_file_location(
        'stand_in', Path(__file__).parent / 'stand_in.py')
    stand_in = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(stand_in)
    nodes, _ = stand_in.launch(PAGE.parents[1] / 'launch/ros2_control.launch.py', arm='ur5e')
    simulator, transforms, manager, spawner = nodes
    assert simulator.parameters[-1]['lockstep'] is False
    assert simulator.parameters[-1]['effort_convention'] == 'gravity_excluded'
    description = ElementTree.fromstring(transforms.parameters[1]['robot_description'])
    assert description.find('ros2_control') is not None
    assert simulator.parameters[-1]['arm'] == 'ur5e' and description.get('name') == 'ur5e'
    for node in (transforms, manager):
        assert 'robot_description:=/tagged_description' in node.arguments
    assert 'use_sim_time:=true' in manager.arguments
    assert spawner.arguments[0] == 'arm_effort_controller'
    controllers = yaml.safe_load((config_folder() / 'controllers.yaml').read_text())
    names = [name for name in controllers if name != 'controller_manager']
    assert 'forward_effort_controller' not in names, 'the simulator listens to that one'
    assert set(names) <= set(controllers['controller_manager']['ros__parameters'])
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'nowhere'))
    with pytest.raises(InputError, match='ros-jazzy-controller-manager'):
        stand_in.launch(PAGE.parents[1] / 'launch/ros2_control.launch.py')
