"""Services called too often, twice, in the wrong state, and while the node ends."""

import signal

import numpy as np
import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


@pytest.mark.fault(26)
def test_services_flooded_and_called_in_the_wrong_state_answer_or_refuse(
        ros, record_property):
    sim, control = ros.start('sim'), ros.start('control')
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: len(states) > 50, 'a run')
    step = watcher.call(Trigger, '/ur5_sim/step')
    assert not step.success  # not paused
    assert 'pause' in step.message
    for expected in (True, True, False, False):
        assert watcher.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=expected)).success
    names = ('/ur5_sim/reset', '/ur5_sim/step', '/ur5_control/hold',
             '/ur5_control/start_experiment')
    for name in names:  # all known before the flood begins
        watcher.call(Trigger, name)
    futures = [watcher.call_async(Trigger, name) for _ in range(20) for name in names]
    wait_until(lambda: all(future.done() for future in futures), 'eighty answers')
    assert all(future.result().success or future.result().message for future in futures)
    record_property('service calls answered', len(futures))
    began = stamp(states[-1])
    wait_until(lambda: stamp(states[-1]) > began + 200_000_000, 'the loop to go on')
    assert np.isfinite(states[-1].position).all()
    calls = [watcher.call_async(Trigger, '/ur5_sim/reset') for _ in range(5)]
    assert sim.stop(signal.SIGTERM) == 0, sim.text
    assert control.stop() == 0, control.text
    assert 'Traceback' not in sim.text + control.text
    assert len(calls) == 5
