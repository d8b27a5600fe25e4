"""What `ros2 param`, `ros2 node` and remapping show of a node under another name."""

import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python
from ros_processes import ros_domain, wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS


class RunningPlant:
    """A simulator whose parameters are set, as values of Python are typed."""

    def __init__(self, ros) -> None:
        self.watcher = ros.observer()

    def __call__(self, name: str, value):
        """Set a parameter; return the answer."""
        request = SetParameters.Request(parameters=[
            Parameter(name, value=value).to_parameter_msg()])
        return self.watcher.call(SetParameters, '/ur5_sim/set_parameters', request).results[0]


@pytest.fixture(scope='module')
def plant(tmp_path_factory):
    """Start a simulator once."""
    with ros_domain(tmp_path_factory.mktemp('typed')) as ros:
        sim = ros.start('sim', bag='none')
        yield RunningPlant(ros)
        assert sim.stop() == 0, sim.text


@pytest.mark.parametrize(('node', 'parameters'), [
    ('sim', SIM_PARAMETERS), ('control', CONTROL_PARAMETERS)])
def test_every_parameter_of_a_renamed_node_is_listed_with_its_words_and_range(ros, node,
                                                                              parameters):
    watcher = ros.observer()
    process = ros.start(node, ['-r', '__node:=other'], namespace='/left', bag='')
    request = ListParameters.Request()
    names = set(watcher.call(ListParameters, '/left/other/list_parameters', request).result.names)
    declared = {parameter.name: parameter for parameter in parameters}
    assert set(declared) <= names
    described = watcher.call(DescribeParameters, '/left/other/describe_parameters',
                             DescribeParameters.Request(names=list(declared))).descriptors
    ranges = 0
    for seen in described:
        parameter = declared[seen.name]
        assert seen.description
        assert seen.read_only == (not parameter.live), seen.name
        for span in (*seen.floating_point_range, *seen.integer_range):
            assert (span.from_value, span.to_value) == (parameter.lower, parameter.upper)
            ranges += 1
    scalars = [each for each in parameters
               if type(each.default) in (int, float)]
    assert ranges == len(scalars) > 3
    assert process.stop() == 0


def test_a_value_out_of_its_range_is_refused_and_services_follow_the_name(ros):
    watcher = ros.observer()
    sim = ros.start('sim', ['-r', '__node:=plant', '-r', 'joint_states:=states'],
                    namespace='/left', bag='', lockstep=False, control_rate=100)
    states = watcher.subscribe(JointState, '/left/states')
    wait_until(lambda: states, 'a state on the remapped topic')
    heavy = ParameterMessage(name='payload.mass', value=ParameterValue(
        type=ParameterType.PARAMETER_DOUBLE, double_value=1e6))
    result = watcher.call(SetParameters, '/left/plant/set_parameters',
                          SetParameters.Request(parameters=[heavy])).results[0]
    assert not result.successful and 'payload.mass' in result.reason
    assert watcher.call(Trigger, '/left/plant/reset').success
    assert sim.stop() == 0


@pytest.mark.parametrize(('name', 'value', 'words'), [
    ('payload.mass', -1, 'payload.mass is -1; give 0 to 1000'),
    ('payload.mass', 'heavy', "payload.mass is 'heavy'; give a number"),
    ('friction.viscous', [1, 2, 3], 'friction.viscous has 3 numbers; give 6'),
    ('friction.viscous', '[.nan, 1, 1, 1, 1, 1]', 'friction.viscous is nan; give a finite number'),
    ('friction.viscous', '[1, 2', "friction.viscous is '[1, 2'; give a list of numbers"),
    ('nosuch', 1, "unknown parameter 'nosuch'; the parameters are: "),
    ('control_rate', 'fast', 'read-only parameter: control_rate'),
])
def test_a_wrong_value_is_refused_by_name_value_and_limit_whatever_its_type(plant, name, value,
                                                                            words):
    """The middleware's own words were "expected DOUBLE got INTEGER", and no name at all."""
    result = plant(name, value)
    assert not result.successful
    assert words in result.reason and '\n' not in result.reason


@pytest.mark.parametrize(('name', 'typed', 'taken'), [
    ('payload.mass', 1, 1.0),
    ('payload.mass', '1e-3', 1e-3),
    ('friction.viscous', [1, 2, 3, 4, 5, 6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
    ('friction.viscous', '[0.5, 1, 1, 1, 1, 1]', [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]),
])
def test_numbers_are_taken_however_the_command_line_types_them(plant, name, typed, taken):
    """``ros2 param set`` sends a list of mixed numbers, and 1e-3, as texts."""
    assert plant(name, typed).successful
    read = plant.watcher.call(GetParameters, '/ur5_sim/get_parameters',
                              GetParameters.Request(names=[name])).values[0]
    assert np.array_equal(parameter_value_to_python(read), taken)


def test_the_topic_of_a_ros2_control_controller_can_be_left_to_it(ros):
    sim = ros.start('sim', bag='none', forward_commands=False)
    sim.wait_for_line('recorded in')
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states, 'a state')
    wait_until(lambda: watcher.node.count_subscribers('/joint_command') == 1, 'its subscriptions')
    assert watcher.node.count_subscribers('/forward_effort_controller/commands') == 0
    assert sim.stop() == 0
