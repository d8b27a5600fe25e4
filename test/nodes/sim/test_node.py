"""The simulator on its topics and services, driven by a plain rclpy program."""

import json
import signal
from copy import deepcopy
from types import SimpleNamespace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from ros_processes import TIMEOUT, send_until, wait_until
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool, Trigger

from ur5_ros.bag.reader import open_bag
from ur5_ros.config import load_arm
from ur5_ros.config.parameters import HOME
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.nodes.sim.services import set_compensation
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.plant import plant_from_parameters

TORQUE = np.array([1.0, -35.0, -10.0, 0.5, 0.2, -0.1])


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def command(state, torque=TORQUE, names=JOINT_NAMES) -> JointState:
    message = JointState(name=list(names), effort=[float(value) for value in torque])
    message.header.stamp = deepcopy(state.header.stamp)
    return message


def answerer(watcher, publisher):
    """Return what answers each new state with the same torque."""
    answered = set()

    def react(state):
        if stamp(state) not in answered:
            answered.add(stamp(state))
            publisher.publish(command(state))
    return react


def events(received, kind):
    return [{pair.key: json.loads(pair.value) for pair in message.status[0].values}
            for message in received if message.status[0].name == kind]


def test_a_plain_controller_gets_the_states_of_the_plant_without_ros(ros):
    watcher = ros.observer()
    sim = ros.start('sim', stop_after=0.2)
    publisher = watcher.publisher(JointState, '/joint_command')
    states = watcher.subscribe(JointState, '/joint_states', react=answerer(watcher, publisher))
    assert sim.ends() == 0, sim.text
    wait_until(lambda: stamp(states[-1]) == 200_000_000, 'the last state')
    plant = plant_from_parameters({})
    expected = [plant.state] + [plant.step(TORQUE) for _ in range(199)]
    plant.close()
    received = {stamp(state): state for state in states}
    assert sorted(received) == [state.stamp for state in expected]
    for state in expected:
        assert received[state.stamp].position.tolist() == state.q.tolist()
        assert received[state.stamp].velocity.tolist() == state.qd.tolist()
        assert received[state.stamp].effort.tolist() == state.effort.tolist()


def test_steps_while_paused_give_the_states_of_running(ros):
    watcher = ros.observer()
    ros.start('sim')
    publisher = watcher.publisher(JointState, '/joint_command')
    assert not watcher.call(Trigger, '/ur5_sim/step').success
    assert watcher.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=True)).success
    states = watcher.subscribe(JointState, '/joint_states', react=answerer(watcher, publisher))
    for k in range(2, 12):
        done = watcher.call(Trigger, '/ur5_sim/step')
        assert (done.success, done.message) == (True, f'state {k} is published')
    wait_until(lambda: states and stamp(states[-1]) == 11_000_000, 'state 11')
    plant = plant_from_parameters({})
    for _ in range(10):
        expected = plant.step(TORQUE)
    plant.close()
    assert states[-1].position.tolist() == expected.q.tolist()


def test_a_step_waits_for_its_command_while_other_services_answer(ros):
    watcher = ros.observer()
    ros.start('sim')
    publisher = watcher.publisher(JointState, '/joint_command')
    states = watcher.subscribe(JointState, '/joint_states')
    watcher.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=True))
    step = watcher.call_async(Trigger, '/ur5_sim/step')
    assert watcher.set_parameters('ur5_sim', payload__mass=1.0).successful
    assert watcher.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=True)).success
    assert not step.done()
    wait_until(lambda: states, 'a copy of state 1')
    publisher.publish(command(states[-1]))
    wait_until(step.done, 'the step')
    assert step.result().success


def test_a_reset_puts_the_arm_back_under_the_next_stamp(ros):
    watcher = ros.observer()
    ros.start('sim', stop_after=0)
    publisher = watcher.publisher(JointState, '/joint_command')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    states = watcher.subscribe(JointState, '/joint_states', react=answerer(watcher, publisher))
    wait_until(lambda: len(states) > 50, 'fifty states')
    assert watcher.call(Trigger, '/ur5_sim/reset').success
    wait_until(lambda: len(events(reported, 'reset')) == 1, 'the event')
    where = next(message for message in reported if message.status[0].name == 'reset')
    wait_until(lambda: stamp(states[-1]) > stamp(where), 'states after it')
    stamps = list(dict.fromkeys(stamp(state) for state in states))
    assert stamps == sorted(stamps)
    again = next(state for state in states if stamp(state) == stamp(where))
    assert again.position.tolist() == HOME


SPOILT = [
    lambda message: message.effort.__setitem__(2, float('nan')),
    lambda message: message.effort.__setitem__(2, float('inf')),
    lambda message: message.effort.append(0.0),
    lambda message: message.name.__setitem__(0, 'no_joint'),
    lambda message: message.name.__setitem__(0, JOINT_NAMES[1]),
    lambda message: message.name.pop(),
    lambda message: setattr(message, 'name', []),
    lambda message: setattr(message, 'name', ['x' * 100] * 2000),
    lambda message: setattr(message.header.stamp, 'sec', 7),
    lambda message: setattr(message.header.stamp, 'sec', -7),
]


def test_wrong_commands_are_refused_whole_and_counted(ros):
    watcher = ros.observer()
    sim = ros.start('sim')
    publisher = watcher.publisher(JointState, '/joint_command')
    reported = watcher.subscribe(DiagnosticArray, '/diagnostics')
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states, 'state 1')

    def refused():
        values = reported[-1].status[0].values if reported else []
        return sum(int(pair.value) for pair in values
                   if pair.key.startswith('refused /joint_command'))

    for count, spoil in enumerate(SPOILT, 1):
        wrong = command(states[-1])
        spoil(wrong)
        send_until(lambda wrong=wrong: publisher.publish(wrong),
                   lambda count=count: refused() >= count, f'{count} in the diagnostics')
        assert refused() == count
    assert {stamp(state) for state in states} == {1_000_000}
    publisher.publish(command(states[-1]))
    wait_until(lambda: stamp(states[-1]) == 2_000_000, 'state 2 after a right command')
    assert sim.stop() == 0


def test_names_in_another_order_are_matched(ros):
    watcher = ros.observer()
    ros.start('sim')
    publisher = watcher.publisher(JointState, '/joint_command')
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states, 'state 1')
    publisher.publish(command(states[-1], TORQUE[::-1], JOINT_NAMES[::-1]))
    wait_until(lambda: stamp(states[-1]) == 2_000_000, 'state 2')
    assert states[-1].effort.tolist() == TORQUE.tolist()


def test_zeros_hold_the_arm_in_the_robots_own_convention(ros):
    watcher = ros.observer()
    ros.start('sim', effort_convention='gravity_excluded', stop_after=0.5)
    zeros = Float64MultiArray(data=[0.0] * 6)
    publisher = watcher.publisher(Float64MultiArray, '/forward_effort_controller/commands')
    seen = set()

    def answer(state):
        if stamp(state) not in seen:
            seen.add(stamp(state))
            publisher.publish(zeros)

    states = watcher.subscribe(JointState, '/joint_states', react=answer)
    wait_until(lambda: states and stamp(states[-1]) == 500_000_000, 'the last state')
    arm = load_arm('ur5')
    home = np.array(HOME)
    assert np.abs(np.array(states[-1].position) - home).max() < 1e-9
    assert np.allclose(states[-1].effort, gravity_torque(home + arm.angle_offset, arm))


def test_a_wrench_pushes_in_its_frame_and_an_unknown_frame_is_refused(ros):
    watcher = ros.observer()
    ros.start('sim')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    publisher = watcher.publisher(WrenchStamped, '/ur5_sim/external_wrench')
    for frame, force in (('base', 5.0), ('base_link', 5.0), ('tool0', 5.0), ('world', 5.0),
                         ('base', float('nan'))):
        message = WrenchStamped()
        message.header.frame_id = frame
        message.wrench.force.x = force
        publisher.publish(message)
    wait_until(lambda: (len(events(reported, 'wrench')) == 3
                        and len(events(reported, 'refused')) == 1),
               'three wrenches and a refusal')
    forces = [each['force'] for each in events(reported, 'wrench')]
    assert forces[0] == [5.0, 0.0, 0.0]
    assert forces[1] == [-5.0, 0.0, 0.0]
    assert np.linalg.norm(forces[2]) == pytest.approx(5.0)
    assert 'world' in events(reported, 'refused')[0]['reason']


@pytest.mark.parametrize('force', [1e300, -1e6, float('inf'), float('nan')])
def test_a_wrench_that_no_robot_meets_is_refused_with_the_limit(ros, force):
    watcher = ros.observer()
    ros.start('sim')
    reports = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    message = WrenchStamped()
    message.wrench.force.y = force
    watcher.publisher(WrenchStamped, '/ur5_sim/external_wrench').publish(message)
    wait_until(lambda: events(reports, 'refused'), 'the refusal')
    assert 'of at most 100000' in events(reports, 'refused')[0]['reason']
    assert not events(reports, 'wrench')


def test_live_parameters_change_the_plant_and_the_rest_is_refused(ros):
    watcher = ros.observer()
    ros.start('sim')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    watcher.publisher(JointState, '/joint_command')
    assert watcher.set_parameters('ur5_sim', payload__mass=2, friction__viscous=[1.0] * 6
                          ).successful
    wait_until(lambda: len(events(reported, 'parameter')) == 2, 'two events')
    for wrong in ({'payload__mass': -1.0}, {'payload__mass': float('nan')},
                  {'friction__viscous': [1.0]}, {'control_rate': 500}, {'fallback': 'panic'},
                  {'use_sim_time': True}, {'noise__position': float('inf')}):
        result = watcher.set_parameters('ur5_sim', **wrong)
        assert not result.successful
        assert result.reason
    assert len(events(reported, 'parameter')) == 2


def test_clock_description_and_run_are_published(ros):
    watcher = ros.observer()
    ros.start('sim', tf_prefix='left_')
    clock = watcher.subscribe(Clock, '/clock')
    description = watcher.subscribe(String, '/robot_description', kept=True)
    run = watcher.subscribe(String, '/ur5_sim/run', kept=True)
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: clock and description and run and states, 'all of them')
    assert clock[0].clock.nanosec == 1_000_000
    assert '<joint name="left_shoulder_pan_joint"' in description[0].data
    assert states[0].name == ['left_' + name for name in JOINT_NAMES]
    assert ros.bag('sim').parent.name == run[0].data


def test_noise_is_seen_in_the_states_and_not_in_the_truth(ros):
    watcher = ros.observer()
    ros.start('sim', noise__position=1e-3, seed=5)
    publisher = watcher.publisher(JointState, '/joint_command')
    truth = watcher.subscribe(JointState, '/ur5_sim/ground_truth')
    states = watcher.subscribe(JointState, '/joint_states', react=answerer(watcher, publisher))
    wait_until(lambda: len(truth) > 100 and len(states) > 100, 'a hundred of each')
    exact = {stamp(state): np.array(state.position) for state in truth}
    errors = [np.array(state.position) - exact[stamp(state)] for state in states[5:90]
              if stamp(state) in exact]
    assert 5e-4 < np.std(errors) < 2e-3


def test_the_timeout_fires_the_arm_brakes_and_a_command_takes_over_again(ros):
    watcher = ros.observer()
    sim = ros.start('sim', lockstep_timeout=0.3)
    publisher = watcher.publisher(JointState, '/joint_command')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states, 'state 1')
    publisher.publish(command(states[-1]))
    wait_until(lambda: stamp(states[-1]) > 100_000_000, 'the simulator running on')
    assert [each['fired'] for each in events(reported, 'lockstep')] == [True]
    publisher.publish(command(states[-1]))
    wait_until(lambda: len(events(reported, 'lockstep')) == 2, 'lockstep again')
    assert np.abs(states[-1].velocity).max() < 1e-6
    assert sim.stop() == 0
    notes = open_bag(ros.bag('sim')).notes['summary']
    assert str(notes['lockstep_fired']) != '0'
    assert str(notes['repeatable']).lower() == 'false'


def test_silence_ends_torque_mode_until_it_is_resumed(ros):
    watcher = ros.observer()
    # a timeout that a busy machine does not reach between two commands
    sim = ros.start('sim', lockstep=False, command_timeout=0.5, leave_torque_mode=True,
                    effort_convention='gravity_excluded', fallback='brake')
    publisher = watcher.publisher(JointState, '/joint_command')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    states = watcher.subscribe(JointState, '/joint_states')
    push = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.5])

    def modes():
        return [each['active'] for each in events(reported, 'torque_mode')]

    def push_until(condition, what):
        wait_until(lambda: publisher.publish(command(states[-1], push)) or condition(), what)

    wait_until(lambda: states, 'states')
    push_until(lambda: modes() == [True], 'torque mode')
    wait_until(lambda: modes() == [True, False], 'the end of torque mode in silence')
    assert watcher.call(Trigger, '/ur5_sim/resume_torque_mode').success
    push_until(lambda: modes() == [True, False, True], 'torque mode again')
    wait_until(lambda: len(modes()) == 4, 'the next silence')
    ignored = stamp(states[-1])
    push_until(lambda: stamp(states[-1]) > ignored + 200_000_000, 'commands into no torque mode')
    assert len(modes()) == 4
    assert np.abs(states[-1].velocity).max() < 1e-6
    assert sim.stop() == 0


def test_scales_of_the_friction_model_are_parameters(ros):
    watcher = ros.observer()
    ros.start('sim')
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    asked = []

    class Node:
        def set_parameters_atomically(self, parameters):
            values = {each.name.replace('.', '__'): each.value for each in parameters}
            asked.append(watcher.set_parameters('ur5_sim', **values))
            return asked[-1]

        def get_logger(self):
            return SimpleNamespace(warning=lambda reason: None)

    scales = SimpleNamespace(viscous_scale=np.full(6, 0.9, np.float32), coulomb_scale=[0.8] * 6)
    assert set_compensation(Node(), scales)
    wait_until(lambda: len(events(reported, 'parameter')) == 2, 'both parameters')
    assert [each['name'] for each in events(reported, 'parameter')] == [
        'friction_compensation.viscous_scale', 'friction_compensation.coulomb_scale']
    assert not set_compensation(Node(), SimpleNamespace(viscous_scale=[3.0] * 6,
                                                        coulomb_scale=[0.8] * 6))
    assert 'viscous_scale' in asked[-1].reason


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_run_in_order(ros, number, times):
    watcher = ros.observer()
    sim = ros.start('sim')
    control = ros.start('control', experiment='joint_step', autostart=True)
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: len(states) > 100, 'a running loop')
    sim.popen.send_signal(number)
    sim.popen.send_signal(number)
    assert sim.ends(times(TIMEOUT, 2.0)) == 0, sim.text
    control.popen.send_signal(number)
    assert control.ends(times(TIMEOUT, 2.0)) == 0, control.text
    for node in ('sim', 'control'):
        bag = open_bag(ros.bag(node))
        assert bag.complete
        assert signal.Signals(number).name in str(bag.notes['summary']['reason'])
    last = open_bag(ros.bag('sim')).joint_states('/joint_states')
    assert np.abs(last.velocity[-1]).max() <= 1e-3
