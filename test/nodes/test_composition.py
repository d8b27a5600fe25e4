"""Both nodes in one process: what others see, who gets which parameter, and how they end."""

import signal
import time

import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from ur5_ros.bag.reader import open_bag


def test_others_see_two_nodes_with_their_topics_and_services(ros):
    ros.start('closed_loop', bag='')
    observer = ros.observer()
    states = observer.subscribe(JointState, '/joint_states')
    commands = observer.subscribe(JointState, '/joint_command')
    wait_until(lambda: states and commands, 'messages of both nodes')
    names = observer.node.get_node_names()
    assert {'ur5_sim', 'ur5_control'} <= set(names) and 'ur5_composed' not in names
    assert observer.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=True)).success
    assert observer.call(Trigger, '/ur5_control/hold').success
    stamp = states[-1].header.stamp
    assert observer.call(Trigger, '/ur5_sim/step').success
    wait_until(lambda: states[-1].header.stamp != stamp, 'the state after a single step')


def test_another_process_moves_the_arm(ros):
    ros.start('closed_loop', bag='')
    observer = ros.observer()
    states = observer.subscribe(JointState, '/joint_states')
    target = observer.publisher(JointState, '/ur5_control/target_joints')
    wait_until(lambda: states, 'a state')
    goal = [0.1, -1.5, 1.5, -1.5, 0.1, 0.1]
    start = states[0].position[0]

    def moves():
        target.publish(JointState(name=states[0].name, position=goal))
        time.sleep(0.2)
        return abs(states[-1].position[0] - start) > 1e-4
    wait_until(moves, 'a movement')
    wait_until(lambda: max(abs(a - b) for a, b in zip(states[-1].position, goal, strict=True))
               < 1e-3, 'the arm at its target')


def test_a_parameter_goes_to_the_node_that_declares_it(ros):
    nodes = ros.start('closed_loop', stop_after=0.2, kp=30.0, monitor_rate=20.0, bag='auto')
    assert nodes.ends() == 0, nodes.text
    sim, control = (open_bag(ros.bag(node)).description['parameters']
                    for node in ('sim', 'control'))
    assert '"kp": [30.0' in control and '"stop_after": 0.2' in sim


@pytest.mark.parametrize('arguments, words', [
    (['-p', 'kq:=1.0'], ['kq']),
    (['-p', 'ur5_sim:kp:=30.0'], ['kp']),
    (['-p', 'ur5_control:stop_after:=1.0'], ['stop_after']),
    (['-p', 'bag:=somewhere'], ['bag', 'ur5_sim:bag:=somewhere/sim']),
    (['-p', 'hot_loop:=executor'], ['hot_loop', 'wait_set']),
    (['-p', 'experiment:=fig12'], ['fig12']),
    (['-p', 'ur5_sim:arm:=ur5_controller'], ['ur5_controller']),
])
def test_bad_input_is_refused_in_one_line(ros, arguments, words):
    nodes = ros.start('closed_loop', arguments)
    assert nodes.ends() == 2, nodes.text
    lines = [line for line in nodes.text.splitlines() if line.startswith('closed_loop: ')]
    assert len(lines) == 1 and all(word in lines[0] for word in words), nodes.text
    assert 'Traceback' not in nodes.text
    assert not (ros.folder / 'bags').exists()


def test_a_second_simulator_in_the_namespace_ends_both_nodes_with_their_bags(ros):
    first = ros.start('sim', bag='')
    observer = ros.observer()
    observer.subscribe(JointState, '/joint_states')
    nodes = ros.start('closed_loop')
    assert nodes.ends() == 2, nodes.text
    assert 'publishes joint_states in this namespace too' in nodes.text
    for node in ('sim', 'control'):
        assert open_bag(ros.bag(node)).complete
    assert first.popen.poll() is None


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_closes_both_bags(ros, number):
    nodes = ros.start('closed_loop')
    observer = ros.observer()
    commands = observer.subscribe(JointState, '/joint_command')
    wait_until(lambda: len(commands) > 100, 'commands')
    assert nodes.stop(number) == 0, nodes.text
    for node in ('sim', 'control'):
        bag = open_bag(ros.bag(node))
        assert bag.complete and not bag.problems
