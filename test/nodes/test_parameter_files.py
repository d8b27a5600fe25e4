"""Parameter files as launch_ros and `ros2 param dump` write them: what rcl reads is obeyed."""

import pytest
import yaml
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python

#: Values that are not the defaults.
GAINS = (20.0, 20.0, 20.0, 10.0, 10.0, 10.0)
PLACE = (0.1, -1.5, 1.5, -1.5, -1.5, 0.2)


def values(watcher, node, names):
    """Return what a node answers to `ros2 param get`."""
    answer = watcher.call(GetParameters, f'{node}/get_parameters',
                          GetParameters.Request(names=list(names)))
    return [parameter_value_to_python(value) for value in answer.values]


@pytest.mark.parametrize(('node', 'given'), [
    ('control', {'kp': GAINS, 'kd': (10.0,), 'tool_speed': 0.2, 'experiment': 'joint_step'}),
    ('sim', {'initial_positions': PLACE, 'friction.viscous': (1.0,) * 6, 'lockstep': False,
             'payload.com': (0.0, 0.0, 0.1), 'bag': 'none', 'control_rate': 500}),
])
def test_the_tags_of_launch_ros_are_read(ros, node, given):
    """launch_ros writes each list as a tuple, by yaml.dump (its actions/node.py)."""
    file = ros.folder / 'launch_params_1'
    file.write_text(yaml.dump({f'/ur5_{node}': {'ros__parameters': given}},
                              default_flow_style=False))
    assert '!!python/tuple' in file.read_text()
    process = ros.start(node, ['--params-file', str(file)])
    watcher = ros.observer()
    found = values(watcher, f'/ur5_{node}', given)
    assert [tuple(each) if hasattr(each, '__len__') and not isinstance(each, str) else each
            for each in found] == list(given.values())
    assert process.stop() == 0, process.text


@pytest.mark.parametrize('node', ['sim', 'control'])
def test_what_param_dump_writes_starts_the_same_node_again(ros, node):
    """`ros2 param dump` nests names at their dots, and writes what every node has too."""
    first = ros.start(node, bag='none')
    watcher, name = ros.observer(), f'/ur5_{node}'
    names = watcher.call(ListParameters, f'{name}/list_parameters').result.names
    tree = {}
    for each, value in zip(names, values(watcher, name, names), strict=True):
        *above, last = each.split('.')
        place = tree
        for part in above:
            place = place.setdefault(part, {})
        place[last] = list(value) if hasattr(value, '__len__') and not isinstance(
            value, str) else value
    assert first.stop() == 0
    file = ros.folder / 'dumped.yaml'
    file.write_text(yaml.safe_dump({name: {'ros__parameters': tree}}))
    assert 'use_sim_time' in tree
    second = ros.start(node, ['--params-file', str(file)])
    second.wait_for_line('run' if node == 'sim' else 'waiting')
    other = ros.observer('other')
    for each, value in zip(names, values(other, name, names), strict=True):
        expected = _at(tree, each)
        assert (list(value) if isinstance(expected, list) else value) == expected, each
    assert second.stop() == 0, second.text


def _at(tree, name):
    for part in name.split('.'):
        tree = tree[part]
    return tree


def test_a_list_without_a_value_is_a_list_of_numbers(ros):
    sim = ros.start('sim', bag='none')
    watcher = ros.observer()
    names = ['gravity', 'payload.com', 'initial_positions']
    described = watcher.call(DescribeParameters, '/ur5_sim/describe_parameters',
                             DescribeParameters.Request(names=names)).descriptors
    assert [each.type for each in described] == [8, 8, 8], 'double array'
    assert not any(each.dynamic_typing for each in described)
    assert sim.stop() == 0
