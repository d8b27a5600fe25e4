"""What `ros2 param`, `ros2 node` and remapping show of a node under another name."""

import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS


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
    states = watcher.hear(JointState, '/left/states')
    wait_until(lambda: states, 'a state on the remapped topic')
    heavy = ParameterMessage(name='payload.mass', value=ParameterValue(
        type=ParameterType.PARAMETER_DOUBLE, double_value=1e6))
    result = watcher.call(SetParameters, '/left/plant/set_parameters',
                          SetParameters.Request(parameters=[heavy])).results[0]
    assert not result.successful and 'payload.mass' in result.reason
    assert watcher.call(Trigger, '/left/plant/reset').success
    assert sim.stop() == 0


def test_the_topic_of_a_ros2_control_controller_can_be_left_to_it(ros):
    sim = ros.start('sim', bag='none', forward_commands=False)
    sim.says('recorded in')
    watcher = ros.observer()
    states = watcher.hear(JointState, '/joint_states')
    wait_until(lambda: states, 'a state')
    wait_until(lambda: watcher.node.count_subscribers('/joint_command') == 1, 'its subscriptions')
    assert watcher.node.count_subscribers('/forward_effort_controller/commands') == 0
    assert sim.stop() == 0
