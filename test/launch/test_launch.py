"""
Launch files say what people type, and the nodes take what the launch files tell them.

A stand-in runs them here; where launch_ros is installed, it runs them as well.
"""

import ast
import importlib.util
import json
import os
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

from ur5_ros.bag.reader import open_bag
from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS
from ur5_ros.signals import JOINT_NAMES

ROOT = Path(__file__).resolve().parents[2]
FILES = ('sim', 'closed_loop', 'rviz')
WANTED = {
    'sim': {'ur_type', 'arm', 'tf_prefix', 'namespace', 'gui', 'lockstep', 'bag', 'stop_after'},
    'closed_loop': {'ur_type', 'arm', 'control_arm', 'experiment', 'tf_prefix', 'namespace',
                    'gui', 'lockstep', 'launch_rviz', 'use_sim_time'},
    'rviz': {'ur_type', 'arm', 'tf_prefix', 'launch_rviz', 'use_sim_time', 'rviz_config_file'},
}
HAVE_LAUNCH = importlib.util.find_spec('launch_ros') is not None


spec = importlib.util.spec_from_file_location('stand_in', Path(__file__).parent / 'stand_in.py')
stand_in = importlib.util.module_from_spec(spec)
spec.loader.exec_module(stand_in)


def tree(name: str) -> ast.Module:
    return ast.parse((ROOT / f'launch/{name}.launch.py').read_text(encoding='utf-8'))


def declared(name: str) -> set[str]:
    """Return the arguments that a launch file declares, read without running it."""
    found = set()
    for node in ast.walk(tree(name)):
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'DeclareLaunchArgument':
            found |= {arg.value for arg in node.args if isinstance(arg, ast.Constant)}
        if isinstance(node, ast.Assign) and getattr(node.targets[0], 'id', '') == 'ARGUMENTS':
            found |= {key.value for key in node.value.keys}
    return found


def node_parameters(name: str) -> dict[str, set[str]]:
    """Return, for each executable of a launch file, the parameter names that it is given."""
    found = {}
    for call in ast.walk(tree(name)):
        if isinstance(call, ast.Call) and getattr(call.func, 'id', '') == 'Node':
            words = {keyword.arg: keyword.value for keyword in call.keywords}
            found[words['executable'].value] = {
                key.value for part in ast.walk(words['parameters'])
                if isinstance(part, ast.Dict) for key in part.keys}
    return found


@pytest.mark.parametrize('name', FILES)
def test_a_launch_file_declares_the_arguments_people_try(name):
    assert declared(name) >= WANTED[name]


@pytest.mark.parametrize('name', FILES)
def test_every_argument_that_a_launch_file_reads_is_declared(name):
    read = {call.args[0].value for call in ast.walk(tree(name))
            if isinstance(call, ast.Call) and getattr(call.func, 'id', '') == 'LaunchConfiguration'
            and isinstance(call.args[0], ast.Constant)}
    assert read <= declared(name)


@pytest.mark.parametrize('name', ['sim', 'closed_loop'])
def test_a_launch_file_sets_only_parameters_that_the_node_has(name):
    known = {'sim_node': {parameter.name for parameter in SIM_PARAMETERS},
             'control_node': {parameter.name for parameter in CONTROL_PARAMETERS}}
    for executable, given in node_parameters(name).items():
        assert given and given <= known[executable]


def launched(name: str, **arguments: str):
    return stand_in.launch(ROOT / f'launch/{name}.launch.py', **arguments)


def test_the_arguments_people_try_reach_the_nodes():
    nodes, environment = launched(
        'closed_loop', ur_type='ur10e', tf_prefix='left_', namespace='left', gui='true',
        lockstep='false', experiment='joint_step', launch_rviz='true', use_sim_time='false')
    assert [node.executable for node in nodes] == [
        'sim_node', 'control_node', 'robot_state_publisher', 'rviz2']
    simulator, controller = (node.parameters[-1] for node in nodes[:2])
    assert (simulator['arm'], controller['arm']) == ('ur10e', 'ur10e')
    assert (simulator['gui'], simulator['lockstep'], simulator['stop_after']) == (True, False, 8.0)
    assert controller['experiment'] == 'joint_step'
    assert all('__ns:=/left' in ' '.join(node.arguments) for node in nodes)
    transforms, rviz = nodes[2:]
    assert transforms.parameters[0] == {'use_sim_time': False}
    assert 'left_shoulder_pan_joint' in transforms.parameters[1]['robot_description']
    assert 'left_base_link' in rviz.arguments
    assert environment['FASTRTPS_DEFAULT_PROFILES_FILE'].endswith('fastdds_loopback.xml')


def test_what_nobody_asked_for_is_not_started():
    assert len(launched('closed_loop')[0]) == 2
    assert len(launched('rviz', launch_rviz='false')[0]) == 1
    assert launched('sim', loopback='false')[1] == {}
    assert [node.parameters[-1]['bag'] for node in launched('closed_loop', bag='')[0]] == ['', '']
    assert launched('sim', ur_type='ur3e')[0][0].parameters[-1]['arm'] == 'ur3e'
    assert launched('sim', ur_type='ur3e', arm='ur20')[0][0].parameters[-1]['arm'] == 'ur20'


@pytest.mark.parametrize('namespace', ['', 'left'])
def test_both_nodes_run_the_experiment_with_what_the_launch_file_gives_them(namespace, tmp_path):
    nodes, environment = launched(
        'closed_loop', experiment='joint_step', control_rate='125', tf_prefix='left_',
        ur_type='ur5e', namespace=namespace, bag=str(tmp_path / 'run'))
    domain = '178' if namespace else '179'
    started = []
    try:
        for node in nodes:
            log = (tmp_path / f'{node.executable}.log').open('w')
            started.append(subprocess.Popen(
                [Path(sys.executable).parent / node.executable, *node.arguments], cwd=tmp_path,
                env=os.environ | environment | {'ROS_DOMAIN_ID': domain},
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT))
        assert started[0].wait(timeout=300) == 0, (tmp_path / 'sim_node.log').read_text()
        started[1].send_signal(signal.SIGINT)
        assert started[1].wait(timeout=60) == 0, (tmp_path / 'control_node.log').read_text()
    finally:
        for process in started:
            if process.poll() is None:
                process.kill()
                process.wait()
    bag = open_bag(tmp_path / 'run/sim')
    prefix = f'/{namespace}' if namespace else ''
    states = bag.joint_states(f'{prefix}/joint_states')
    assert len(states.stamp) >= 8 * 125
    assert list(states.names) == [f'left_{name}' for name in JOINT_NAMES]
    assert abs(states.position[-1] - states.position[0]).max() > 0.15, 'the step of the experiment'


def test_rviz_shows_topics_that_the_nodes_have():
    layout = yaml.safe_load((ROOT / 'config/layouts/ur5.rviz').read_text(encoding='utf-8'))
    displays = layout['Visualization Manager']['Displays']
    topics = {display[key]['Value'] for display in displays
              for key in ('Topic', 'Description Topic') if key in display}
    assert topics == {'/robot_description', '/ur5_control/tool_pose',
                      '/ur5_control/reference_pose'}


def test_plotjuggler_draws_every_joint_by_its_name():
    root = ElementTree.parse(ROOT / 'config/layouts/plotjuggler.xml').getroot()
    curves = {curve.get('name') for curve in root.iter('curve')}
    for joint in JOINT_NAMES:
        assert {f'/joint_states/{joint}/position', f'/joint_states/{joint}/velocity',
                f'/joint_states/{joint}/effort', f'/joint_command/{joint}/effort',
                f'/ur5_control/error/{joint}/position'} <= curves


def test_every_foxglove_panel_that_is_placed_is_described():
    layout = json.loads((ROOT / 'config/layouts/foxglove.json').read_text(encoding='utf-8'))

    def panels(place):
        if isinstance(place, str):
            return {place}
        return panels(place['first']) | panels(place['second'])

    assert panels(layout['layout']) == set(layout['configById'])


if HAVE_LAUNCH:  # a full ROS installation: launch and launch_ros are not among the PyPI packages
    @pytest.mark.parametrize('name', FILES)
    def test_a_launch_file_runs_up_to_its_processes(name):
        from launch import LaunchContext
        from launch.actions import DeclareLaunchArgument, OpaqueFunction

        path = ROOT / f'launch/{name}.launch.py'
        spec = importlib.util.spec_from_file_location(f'{name}_launch', path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        context, processes = LaunchContext(), 0
        for entity in module.generate_launch_description().entities:
            if isinstance(entity, DeclareLaunchArgument):
                entity.execute(context)
            elif isinstance(entity, OpaqueFunction):
                processes += len(entity.execute(context))
            else:
                processes += hasattr(entity, 'node_executable')
        assert processes
