"""Very many hostile commands through the middleware to a node that runs."""

import random
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from hostile import hostile_command
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag
from ur5_ros.config import load_arm

#: Commands sent at once: half of what the node's subscription holds.
AT_ONCE = 5


@pytest.mark.timeout(3600)
@pytest.mark.fault(1, 2, 3, 5, 6, 7, 9, 10, 17, 18, 22, 83)
def test_hostile_commands_through_the_middleware_are_judged_one_by_one(
        ros, times, record_property):
    expected, dice = times(2_000, 100_000), random.Random(6)
    sim, watcher = ros.start('sim', max_bagfile_duration=0.0), ros.observer()
    reported = watcher.subscribe(DiagnosticArray, '/diagnostics')
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states, 'state 1')
    publisher = watcher.publisher(JointState, '/joint_command')
    sent, began = 0, time.monotonic()
    while judged(reported) < expected:  # best effort loses some where the machine is busy
        assert sent < 8 * expected, (
            f'{judged(reported)} of {sent} commands judged: {sim.text[-500:]}')
        for _ in range(100):
            now = states[-1].header.stamp
            for _ in range(AT_ONCE):
                publisher.publish(hostile_command(dice, now.sec * 10**9 + now.nanosec))
            sent += AT_ONCE
            time.sleep(0.0005)
        del states[:-1], reported[:-2]
        time.sleep(0.1)  # the node tells what it has judged once a second
    record_property('hostile commands sent through the middleware', sent)
    record_property('hostile commands judged by the node', judged(reported))
    record_property('hostile commands sent [1/s]', sent / (time.monotonic() - began))
    assert sim.stop() == 0, sim.text
    assert 'Traceback' not in sim.text
    recorded = open_bag(ros.bag('sim')).joint_states('/joint_states')
    assert len(recorded.stamp) > 10  # some were good
    assert np.isfinite(recorded.position).all()
    assert (np.abs(recorded.effort) <= load_arm('ur5').limits.effort).all()


def judged(reported) -> int:
    """Return how many commands the simulator took or refused, from its newest diagnostics."""
    if not reported:
        return 0
    return sum(int(pair.value) for pair in reported[-1].status[0].values
               if pair.key in ('commands_taken', 'commands_copied')
               or pair.key.startswith('refused /joint_command'))
