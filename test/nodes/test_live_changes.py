"""A live change is made whole or not at all, and the loop goes on meanwhile."""

import time

import numpy as np
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python
from ros_processes import wait_until
from sensor_msgs.msg import JointState

#: Longest time without a state while a change is compiled [s]; the machine may be busy.
LONGEST_GAP = 1.5


def value(watcher, node, name):
    answer = watcher.call(GetParameters, f'{node}/get_parameters',
                          GetParameters.Request(names=[name]))
    return parameter_value_to_python(answer.values[0])


def test_states_go_on_while_the_friction_of_a_live_change_is_compiled(ros):
    """With a cold cache of kernels, the loop stood still for six seconds."""
    control = ros.start('control', bag='none')
    sim = ros.start('sim', control_rate=100, physics_rate=1000, bag='none',
                    environment={'NUMBA_CACHE_DIR': str(ros.folder / 'cache')})
    watcher, times = ros.observer(), []
    watcher.subscribe(JointState, '/joint_states', react=lambda _: times.append(time.monotonic()))
    wait_until(lambda: len(times) > 100, 'states')
    answer = watcher.set_parameters('ur5_sim', friction__viscous=[1.0] * 6)
    assert answer.successful, answer.reason
    assert list(value(watcher, '/ur5_sim', 'friction.viscous')) == [1.0] * 6
    count = len(times)
    wait_until(lambda: len(times) > count + 20, 'states under friction')
    assert np.diff(times).max() < LONGEST_GAP
    assert sim.stop() == 0, sim.text
    assert control.stop() == 0, control.text


def test_of_changes_that_are_refused_none_acts(ros):
    sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000, bag='none')
    control = ros.start('control', bag='none')
    watcher = ros.observer()
    commands = watcher.subscribe(JointState, '/joint_command')
    wait_until(lambda: len(commands) > 20, 'commands')
    answer = watcher.set_parameters('ur5_control', kp=[20.0], kd=[1e6])
    assert not answer.successful and 'kd' in answer.reason
    assert list(value(watcher, '/ur5_control', 'kp')) == [10.0]
    answer = watcher.set_parameters('ur5_sim', payload__mass=1.0, payload__com=[99.0] * 3)
    assert not answer.successful and 'payload.com' in answer.reason
    assert value(watcher, '/ur5_sim', 'payload.mass') == 0.0
    assert control.stop() == 0 and sim.stop() == 0
