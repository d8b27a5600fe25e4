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
from pathlib import Path

import pytest
import yaml

from ur5_ros.bag.reader import open_bag
from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

ROOT = Path(__file__).resolve().parents[2]
FILES = ('sim', 'closed_loop', 'rviz', 'ros2_control')
EXPECTED = {
    'sim': {'ur_type', 'arm', 'tf_prefix', 'namespace', 'gui', 'lockstep', 'bag', 'stop_after',
            'params_file'},
    'closed_loop': {'ur_type', 'arm', 'control_arm', 'experiment', 'tf_prefix', 'namespace',
                    'gui', 'lockstep', 'launch_rviz', 'use_sim_time', 'params_file'},
    'rviz': {'ur_type', 'arm', 'tf_prefix', 'launch_rviz', 'use_sim_time', 'rviz_config_file',
             'params_file'},
    'ros2_control': {'ur_type', 'arm', 'controller', 'controllers_file', 'bag', 'params_file'},
}
HAVE_LAUNCH = importlib.util.find_spec('launch_ros') is not None


spec = importlib.util.spec_from_file_location('stand_in', Path(__file__).parent / 'stand_in.py')
stand_in = importlib.util.module_from_spec(spec)
spec.loader.exec_module(stand_in)


def tree(name: str) -> ast.Module:
    return ast.parse((ROOT / f'launch/{name}.launch.py').read_text(encoding='utf-8'))


def declared(name: str) -> set[str]:
    """Return the arguments that a launch file declares."""
    return {action.words[0] for action in stand_in.description(
        ROOT / f'launch/{name}.launch.py') if isinstance(action, stand_in.Declare)}


@pytest.mark.parametrize('name', FILES)
def test_a_launch_file_declares_the_arguments_people_try(name):
    assert declared(name) >= EXPECTED[name]


@pytest.mark.parametrize('name', FILES)
def test_every_argument_that_a_launch_file_reads_is_declared(name):
    read = {call.args[0].value for call in ast.walk(tree(name))
            if isinstance(call, ast.Call) and getattr(call.func, 'id', '') == 'LaunchConfiguration'
            and isinstance(call.args[0], ast.Constant)}
    assert read <= declared(name)


def launched(name: str, **arguments: str):
    return stand_in.launch(ROOT / f'launch/{name}.launch.py', **arguments)


@pytest.fixture
def rviz_installed(tmp_path, monkeypatch):
    """An installation in which robot_state_publisher and rviz2 can be found."""
    index = tmp_path / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    for package in ('robot_state_publisher', 'rviz2', 'controller_manager',
                    'joint_state_topic_hardware_interface'):
        (index / package).touch()
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))


#: Every argument of the launch files with a value that is not the default.
EVERY = {
    'ur_type': 'ur10e', 'arm': 'ur5e', 'control_arm': 'ur20', 'experiment': 'joint_step',
    'tf_prefix': 'left_', 'namespace': 'left', 'gui': 'true', 'lockstep': 'false',
    'control_rate': '250', 'physics_rate': '500', 'realtime_factor': '0.5',
    'effort_convention': 'gravity_excluded', 'stop_after': '2', 'bag': 'somewhere',
    'launch_rviz': 'true', 'use_sim_time': 'false', 'loopback': 'false', 'composed': 'false',
    'rviz_config_file': str(ROOT / 'config/layouts/ur5.rviz'),
    'params_file': str(ROOT / 'config/sim.yaml'), 'preset': 'ur_torque_mode',
}


@pytest.mark.parametrize('name', ['sim', 'closed_loop'])
def test_every_argument_is_taken_and_the_nodes_have_each_parameter(name, rviz_installed):
    known = {'sim_node': {parameter.name for parameter in SIM_PARAMETERS},
             'control_node': {parameter.name for parameter in CONTROL_PARAMETERS}}
    arguments = {each: EVERY[each] for each in declared(name)}
    nodes, environment = launched(name, **arguments)
    assert environment == {}, 'loopback:=false'
    for node in nodes:
        if node.executable in known:
            given = node.parameters[-1]
            assert given and set(given) <= known[node.executable]
            assert str(ROOT / 'config/sim.yaml') in node.parameters[1:], 'params_file'
            for each in ('control_rate', 'lockstep', 'effort_convention', 'tf_prefix'):
                assert each not in given or str(given[each]).lower() == EVERY[each]


def test_the_arguments_people_try_reach_the_nodes(rviz_installed):
    nodes, environment = launched(
        'closed_loop', ur_type='ur10e', tf_prefix='left_', namespace='left', gui='true',
        lockstep='false', experiment='joint_step', launch_rviz='true', use_sim_time='false')
    assert [node.executable for node in nodes] == [
        'robot_state_publisher', 'rviz2', 'sim_node', 'control_node']
    simulator, controller = (node.parameters[-1] for node in nodes[2:])
    assert (simulator['arm'], controller['arm']) == ('ur10e', 'ur10e')
    assert (simulator['gui'], simulator['lockstep'], simulator['stop_after']) == (True, False, 8.0)
    assert controller['experiment'] == 'joint_step'
    assert all('__ns:=/left' in ' '.join(node.arguments) for node in nodes)
    transforms, rviz = nodes[:2]
    assert transforms.parameters[0] == {'use_sim_time': False}
    assert 'left_shoulder_pan_joint' in transforms.parameters[1]['robot_description']
    assert 'left_base_link' in rviz.arguments
    assert environment['FASTRTPS_DEFAULT_PROFILES_FILE'].endswith('fastdds_loopback.xml')


def test_what_was_not_asked_for_is_not_started(rviz_installed):
    assert len(launched('closed_loop')[0]) == 2
    assert len(launched('rviz', launch_rviz='false')[0]) == 1
    assert launched('sim', loopback='false')[1] == {}
    assert launched('sim', ur_type='ur3e')[0][0].parameters[-1]['arm'] == 'ur3e'
    assert launched('sim', ur_type='ur3e', arm='ur20')[0][0].parameters[-1]['arm'] == 'ur20'


@pytest.mark.parametrize('text', ['none', "''", '""'])
def test_there_is_a_word_for_no_bag(text):
    assert [node.parameters[-1]['bag'] for node in launched('closed_loop', bag=text)[0]] == [
        'none', 'none']
    with pytest.raises(ValueError, match='malformed'):  # as launch answers
        launched('sim', bag='')


def test_without_an_experiment_the_arm_is_held_without_an_end():
    simulator, controller = (
        node.parameters[-1] for node in launched('closed_loop', experiment='none')[0])
    assert not {'stop_after', 'initial_positions'} & set(simulator)
    assert not {'experiment', 'autostart'} & set(controller)


@pytest.mark.parametrize(('name', 'argument', 'text', 'way_out'), [
    ('closed_loop', 'lockstep', 'maybe', 'true or false'),
    ('sim', 'gui', 'yes please', 'true or false'),
    ('sim', 'loopback', '127.0.0.1', 'true or false'),
    ('closed_loop', 'launch_rviz', '2', 'true or false'),
    ('closed_loop', 'experiment', 'no_such', 'kebria_fig11'),
    ('sim', 'control_rate', '1e3', 'a whole number'),
    ('sim', 'stop_after', 'never', 'a number'),
    ('sim', 'realtime_factor', 'inf', 'a finite number'),
    ('sim', 'effort_convention', 'full', 'total, gravity_excluded'),
    ('sim', 'params_file', '/nowhere.yaml', 'a file that exists'),
    ('rviz', 'rviz_config_file', '/nowhere.rviz', 'a file that exists'),
])
def test_a_wrong_argument_is_refused_before_anything_is_started(name, argument, text, way_out):
    with pytest.raises(InputError) as refused:
        launched(name, **{argument: text})
    line = str(refused.value)
    assert '\n' not in line and argument in line and repr(text) in line and way_out in line


@pytest.mark.parametrize('name', ['closed_loop', 'rviz'])
def test_what_is_not_installed_ends_the_launch_before_a_node_is_started(name, monkeypatch):
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(ROOT / 'nowhere'))
    with pytest.raises(InputError, match='ros-jazzy-robot-state-publisher'):
        launched(name, launch_rviz='true')


def test_a_parameter_file_is_for_the_nodes_that_it_names(tmp_path):
    file = tmp_path / 'mine.yaml'
    file.write_text('/ur5_control:\n  ros__parameters:\n    kp: [20.0]\n')
    simulator, controller = launched('closed_loop', params_file=str(file))[0]
    assert str(file) in controller.arguments and str(file) not in simulator.arguments
    with pytest.raises(InputError, match='/ur5_sim'):
        launched('sim', params_file=str(file))
    file.write_text('/**:\n  ros__parameters:\n    effort_convention: total\n')
    assert all(str(file) in node.arguments
               for node in launched('closed_loop', params_file=str(file))[0])


def test_what_an_argument_does_not_set_a_parameter_file_does(tmp_path):
    """rcl takes the last value, so that an argument with a default would hide the file's."""
    file = tmp_path / 'mine.yaml'
    file.write_text('/**:\n  ros__parameters:\n    control_rate: 500\n    arm: ur3\n')
    [simulator] = launched('sim', params_file=str(file))[0]
    assert not {'control_rate', 'arm'} & set(simulator.parameters[-1])
    assert simulator.parameters[-2] == str(file)


def test_both_nodes_run_in_one_process_if_asked(tmp_path):
    [node], environment = launched(
        'closed_loop', composed='true', experiment='joint_step', control_rate='125', arm='ur5e',
        control_arm='ur5', bag=str(tmp_path / 'run'))
    done = subprocess.run(
        [sys.executable, '-m', f'ur5_ros.nodes.{node.executable}', *node.arguments], cwd=tmp_path,
        env=os.environ | environment | {'ROS_DOMAIN_ID': '177'}, stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    for name, arm in (('sim', 'ur5e'), ('control', 'ur5')):
        bag = open_bag(tmp_path / 'run' / name)
        parameters = json.loads(bag.description['parameters'])
        assert parameters['arm'] == arm
        assert len(bag.joint_states('/joint_states').stamp) >= 8 * 125 - 1


def test_the_end_of_either_node_ends_the_launch():
    assert all(node.on_exit is not None for node in launched('closed_loop')[0])


@pytest.mark.parametrize('namespace', ['', 'left'])
def test_both_nodes_run_the_experiment_with_what_the_launch_file_gives_them(namespace, tmp_path):
    nodes, environment = launched(
        'closed_loop', experiment='joint_step', control_rate='125', tf_prefix='left_',
        ur_type='ur5e', bag=str(tmp_path / 'run'),
        **({'namespace': namespace} if namespace else {}))
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


def test_a_preset_decides_what_was_not_typed():
    (simulator,), _ = launched('sim', preset='ur_torque_mode', arm='ur10e_real')
    sheet, preset, typed = simulator.parameters
    assert sheet.endswith('sim.yaml') and preset.endswith('presets/ur_torque_mode.yaml')
    assert typed == {'arm': 'ur10e_real'}
    (plain,), _ = launched('sim')
    assert len(plain.parameters) == 2
