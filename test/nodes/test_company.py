"""Nodes that come, go, stop and share the domain: what the others do about it."""

import json
import os
import signal

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from ros_processes import wait_until
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from ur5_ros.bag.reader import open_bag
from ur5_ros.config.parameters import HOME
from ur5_ros.signals import JOINT_NAMES


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def running(states, more=100):
    """Wait for so many new states."""
    count = len(states)
    wait_until(lambda: len(states) > count + more, f'{more} states more')


def kinds(folder, kind):
    """Return the values of the events of a kind in the simulator's bag."""
    return [{pair['key']: json.loads(pair['value']) for pair in message['status'][0]['values']}
            for _, message in open_bag(folder).messages('/ur5_sim/events')
            if message['status'][0]['name'] == kind]


def test_a_controller_that_is_killed_and_started_again_takes_over_without_a_jump(ros):
    watcher = ros.observer()
    sim = ros.start('sim')
    control = ros.start('control')
    states = watcher.subscribe(JointState, '/joint_states')
    running(states)
    control.popen.kill()
    control.ends()
    again = ros.start('control')
    again.wait_for_line('recording')
    running(states)
    assert again.stop() == 0
    assert sim.stop() == 0
    recorded = open_bag(ros.bag('sim')).joint_states('/joint_states')
    assert np.abs(np.diff(recorded.position, axis=0)).max() < 1e-6
    assert np.abs(np.diff(recorded.effort[1:], axis=0)).max() < 1e-3
    assert not kinds(ros.bag('sim'), 'fallback')
    run = ros.bag('sim').parent
    assert sorted(each.name for each in run.iterdir()) == ['control', 'control_2', 'sim']


def test_a_simulator_that_starts_again_is_a_new_run_for_the_controller(ros):
    watcher = ros.observer()
    control = ros.start('control')
    for _ in range(2):
        sim = ros.start('sim', stop_after=0.3)
        states = watcher.subscribe(JointState, '/joint_states')
        assert sim.ends() == 0, sim.text
    assert control.stop() == 0, control.text
    runs = sorted((ros.folder / 'bags').iterdir())
    assert len(runs) == 2
    for run in runs:
        bags = {node: open_bag(run / node) for node in ('sim', 'control')}
        assert bags['control'].description['run'] == run.name
        stamps = bags['control'].joint_states('/joint_states').stamp
        assert stamps.tolist() == [1_000_000 * k for k in range(1, 301)]
        hashes = [str(bag.notes['summary']['hashes']) for bag in bags.values()]
        states = [json.loads(each.replace("'", '"'))['joint_states'] for each in hashes]
        assert states[0] == states[1]


def test_a_state_of_another_robot_is_refused_and_is_in_no_bag_of_this_run(ros):
    control = ros.start('control', control_rate=1000.0)
    watcher = ros.observer()
    commands = watcher.subscribe(JointState, '/joint_command')
    robot = watcher.publisher(JointState, '/joint_states')

    def send(milliseconds: int) -> None:
        state = JointState(name=list(JOINT_NAMES), position=HOME, velocity=[0.0] * 6,
                           effort=[0.0] * 6)
        state.header.stamp.nanosec = milliseconds * 1_000_000
        robot.publish(state)

    send(100)
    wait_until(lambda: len(commands) == 1, 'an answer to the first state')
    for k in (101, 1, 102, 2, 103):  # the stamps of two robots, within moments
        send(k)
    wait_until(lambda: stamp(commands[-1]) == 103_000_000, 'an answer to the last one')
    assert control.stop() == 0, control.text
    assert 'keep one robot on this topic' in control.text
    (bag,) = (ros.folder / 'bags').glob('*/control')
    stamps = open_bag(bag).joint_states('/joint_states').stamp
    assert stamps.tolist() == [1_000_000 * k for k in range(100, 104)]


def test_a_controller_that_sleeps_is_waited_for(ros):
    watcher = ros.observer()
    sim = ros.start('sim', stop_after=3.0)
    control = ros.start('control')
    states = watcher.subscribe(JointState, '/joint_states')
    running(states)
    os.kill(control.pid, signal.SIGSTOP)
    assert watcher.call(Trigger, '/ur5_sim/reset').success  # services go on
    os.kill(control.pid, signal.SIGCONT)
    running(states)
    assert sim.ends() == 0
    assert control.stop() == 0
    assert not kinds(ros.bag('sim'), 'fallback')
    pairs = [open_bag(ros.bag(node)).joint_states('/joint_states').stamp for node in
             ('sim', 'control')]
    assert pairs[0].tolist() == pairs[1].tolist()


def test_two_arms_live_in_two_namespaces(ros):
    clock = ros.observer().subscribe(Clock, '/clock', publishers=0)
    nodes = []
    for side, primary in (('left', True), ('right', False)):
        nodes.append(ros.start('control', namespace=f'/{side}', tf_prefix=f'{side}_'))
        nodes.append(ros.start('sim', namespace=f'/{side}', tf_prefix=f'{side}_', stop_after=0.5,
                               publish_clock=primary))
    for node in nodes[1::2]:
        assert node.ends() == 0, node.text
    for node in nodes[::2]:
        assert node.stop() == 0, node.text
    assert clock
    sides = {}
    for run in (ros.folder / 'bags').iterdir():
        bag = open_bag(run / 'control')
        topic = next(name for name in bag.topics if name.endswith('/joint_states'))
        columns = bag.joint_states(topic)
        assert len(columns.stamp) == 500
        sides[topic] = columns.names[0]
    assert sides == {'/left/joint_states': 'left_shoulder_pan_joint',
                     '/right/joint_states': 'right_shoulder_pan_joint'}


def test_two_controllers_are_named_and_the_first_valid_answer_acts(ros):
    watcher = ros.observer()
    sim = ros.start('sim')
    control = ros.start('control', bag='')
    other = ros.start('control', ['-r', '__node:=intruder'], bag='')
    states = watcher.subscribe(JointState, '/joint_states')
    reported = watcher.subscribe(DiagnosticArray, '/diagnostics')
    wait_until(lambda: any('not repeatable' in message.status[0].message for message in reported),
               'the warning')
    running(states)
    assert np.abs(np.array(states[-1].position) - HOME).max() < 1e-6
    for node in (control, other, sim):
        assert node.stop() == 0
    crowds = kinds(ros.bag('sim'), 'publishers')
    assert any({'/ur5_control', '/intruder'} <= set(event['names']) for event in crowds)


def test_a_paced_run_keeps_wall_time_and_the_arm_where_it_is(ros):
    watcher = ros.observer()
    sim = ros.start('sim', lockstep=False, control_rate=100, stop_after=2.0)
    control = ros.start('control')
    states = watcher.subscribe(JointState, '/joint_states', publishers=0)
    assert sim.ends() == 0, sim.text
    assert control.stop() == 0
    recorded = open_bag(ros.bag('sim'))
    times = recorded.columns('/joint_states').log_time
    assert len(times) == 200
    assert (times[-1] - times[0]) * 1e-9 >= 1.98
    assert np.abs(recorded.joint_states('/joint_states').position - HOME).max() < 1e-3
    assert states
    assert 'late_periods' in str(recorded.notes['summary']['counters'])


def test_as_fast_as_it_goes_needs_no_controller(ros):
    sim = ros.start('sim', lockstep=False, realtime_factor=0.0, stop_after=20.0)
    assert sim.ends() == 0
    recorded = open_bag(ros.bag('sim')).joint_states('/joint_states')
    assert len(recorded.stamp) == 20_000
    assert np.abs(recorded.position - HOME).max() < 1e-6  # the brake holds
    assert [each['mode'] for each in kinds(ros.bag('sim'), 'fallback')] == ['brake']


def test_a_paced_controller_that_is_killed_leaves_the_arm_to_the_brake(ros):
    watcher = ros.observer()
    sim = ros.start('sim', lockstep=False, control_rate=250)
    control = ros.start('control', bag='')
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states and np.abs(states[-1].effort).max() > 1.0, 'a torque')
    control.popen.kill()
    running(states, 250)
    assert np.abs(states[-1].velocity).max() < 1e-3
    assert sim.stop() == 0
    assert kinds(ros.bag('sim'), 'fallback')[-1] == {'mode': 'brake', 'active': True}
