"""Launch files say what people type; where launch_ros is installed they are run as well."""

import ast
import importlib.util
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

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
