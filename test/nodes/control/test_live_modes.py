"""Every law is selected on the running node; gains with which it is unstable are refused."""

from functools import partial

import numpy as np
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.config.parameters import CONTROL_PARAMETERS, HOME

CHOICES = next(each for each in CONTROL_PARAMETERS if each.name == 'mode').choices
WEIGHED = {'kp': [100.0], 'kd': [8.0]}
SPRINGS = {'kp': [400.0, 400.0, 300.0, 60.0, 60.0, 60.0],
           'kd': [40.0, 40.0, 30.0, 5.0, 5.0, 5.0], 'ki': [50.0]}
WITHOUT_M = ('pd', 'gravity_pd', 'impedance', 'pid')


def test_every_law_is_selected_on_the_running_node_and_holds_the_arm(ros):
    sim, control = ros.start('sim', arm='ur5_real'), ros.start('control', arm='ur5_real')
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')

    change = partial(watcher.set_parameters, 'ur5_control')
    wait_until(lambda: len(states) > 10, 'states')
    for mode in CHOICES:
        answer = change(mode=mode, **(SPRINGS if mode in WITHOUT_M else WEIGHED))
        assert answer.successful, (mode, answer.reason)
        received = len(states)
        wait_until(lambda least=received + 200: len(states) > least, f'200 states under {mode}')
        assert np.abs(np.array(states[-1].position) - HOME).max() < 0.5, mode
    answer = change(mode='sliding_mode', kp=[100.0], kd=[2500.0])
    assert not answer.successful
    assert 'unstable when sampled at 1000 Hz' in answer.reason and '\n' not in answer.reason
    assert control.stop() == 0, control.text
    assert sim.stop() == 0, sim.text
    assert 'Traceback' not in control.text
