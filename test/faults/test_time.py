"""Clocks that jump, processors that are busy, errors in callbacks, long runs."""

import json
import os
import sys
from operator import lt

import numpy as np
import psutil
import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag

#: Wraps a node: its wall clock is set an hour forth and two back while it runs.
JUMPING_CLOCK = """
import itertools, time
count, real, real_ns = itertools.count(), time.time, time.time_ns
def jump():
    return {0: 0, 1: 3600, 2: -7200}[(next(count) // 50) % 3]
time.time = lambda: real() + jump()
time.time_ns = lambda: real_ns() + jump() * 10**9
from ur5_ros.nodes.sim_node import main
main(['sim_node', '--ros-args', '-p', 'stop_after:=0.5'])
"""

#: Wraps a node: changing the payload is an error in its code.
BROKEN_CALLBACK = """
from ur5_ros.nodes.ros.start import begin_start
begin_start()
from ur5_ros.sim.plant import Plant
works = Plant.change
def change(self, name, value):
    if name == 'payload.mass':
        raise ZeroDivisionError('injected')
    works(self, name, value)
Plant.change = change
from ur5_ros.nodes.sim_node import main
main(['sim_node'])
"""


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


@pytest.mark.fault(56)
def test_a_wall_clock_that_is_set_leaves_stamps_and_log_times_in_order(ros):
    sim = ros.run([sys.executable, '-c', JUMPING_CLOCK])
    control = ros.start('control', bag='')
    assert sim.ends() == 0, sim.text
    assert control.stop() == 0
    recorded = open_bag(ros.bag('sim')).joint_states('/joint_states')
    assert np.array_equal(np.diff(recorded.stamp), np.full(499, 1_000_000))
    assert (np.diff(recorded.log_time) >= 0).all()
    assert np.ptp(recorded.log_time) < 60e9


@pytest.mark.fault(55)
def test_an_error_inside_a_callback_is_reported_and_the_node_goes_on(ros):
    sim = ros.run([sys.executable, '-c', BROKEN_CALLBACK])
    control = ros.start('control', bag='')
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: len(states) > 50, 'a run')
    assert not watcher.set_parameters('ur5_sim', payload__mass=1.0).successful
    began = stamp(states[-1])
    wait_until(lambda: stamp(states[-1]) > began + 100_000_000, 'the loop to go on')
    assert 'injected' in sim.text
    assert sim.stop() == 0
    assert control.stop() == 0


@pytest.mark.fault(54)
def test_beside_a_busy_process_the_run_has_the_same_bits(ros):
    def hashes(name):
        sim = ros.start('sim', stop_after=0.5, bag=str(ros.folder / name / 'sim'))
        control = ros.start('control', bag='', experiment='joint_step', autostart=True)
        assert sim.ends() == 0, sim.text
        assert control.stop() == 0
        return open_bag(ros.folder / name / 'sim').notes['summary']['hashes']

    quiet = hashes('quiet')
    burner = 'import os; os.sched_setaffinity(0, {%d})\nwhile True: pass'
    burners = [psutil.Popen([sys.executable, '-c', burner % core])  # one for each core
               for core in os.sched_getaffinity(0)]
    try:
        wait_until(lambda: all(burner.cpu_times().user for burner in burners), 'busy cores')
        before = [burner.cpu_times().user for burner in burners]
        loaded = hashes('loaded')
        after = [burner.cpu_times().user for burner in burners]
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()
    assert all(map(lt, before, after))  # the cores were loaded
    assert quiet == loaded


@pytest.mark.fault(60)
def test_the_first_answer_takes_no_longer_than_the_worst_of_the_others(ros):
    sim = ros.start('sim', stop_after=1.0)
    control = ros.start('control', experiment='joint_step', autostart=True)
    assert sim.ends() == 0, sim.text
    assert control.stop() == 0
    bag = open_bag(ros.bag('control'))
    states = bag.joint_states('/joint_states')
    commands = bag.joint_states('/joint_command', names=None)
    assert np.array_equal(states.stamp, commands.stamp)
    delay = (commands.log_time - states.log_time) * 1e-9
    assert delay[0] < max(0.1, 3.0 * delay[1:].max())  # compiled before the first state


@pytest.mark.fault(52, 84)
@pytest.mark.parametrize('first', ['sim', 'control'])
def test_nodes_find_each_other_in_either_order_of_start(ros, first):
    second = {'sim': 'control', 'control': 'sim'}[first]
    nodes = {first: ros.start(first, **({'stop_after': 0.2} if first == 'sim' else {}))}
    watcher = ros.observer()
    wait_until(lambda: 'ur5_' in ' '.join(watcher.node.get_node_names()), 'the first node')
    nodes[second] = ros.start(second, **({'stop_after': 0.2} if second == 'sim' else {}))
    assert nodes['sim'].ends() == 0, nodes['sim'].text
    assert nodes['control'].stop() == 0
    assert len(open_bag(ros.bag('sim')).joint_states('/joint_states').stamp) == 200


@pytest.mark.timeout(3600)
@pytest.mark.thorough
@pytest.mark.fault(59)
def test_over_many_periods_memory_and_files_do_not_grow(long_run, record_property):
    long_run.finish(3000.0)
    record_property('lockstep periods in one run', long_run.periods)
    for node in ('sim', 'control'):
        memory, files = long_run.growth(node)
        record_property(f'growth of resident memory, {node} [MiB]', memory)
        assert memory < 5.0
        assert files <= 2
        stamps = np.unique(long_run.stamps(node))  # state 1 is told again until it is answered
        record_property('periods lost in it, in all', long_run.periods - len(stamps))
        assert np.array_equal(stamps, np.arange(1, long_run.periods + 1) * 1_000_000)


@pytest.mark.fault(35, 37)
@pytest.mark.parametrize(('variables', 'word'), [
    ({'ROS_DOMAIN_ID': 'abc'}, 'ROS_DOMAIN_ID'), ({'ROS_DOMAIN_ID': '233'}, 'ROS_DOMAIN_ID'),
    ({'ROS_SECURITY_ENABLE': 'true'}, 'ROS_SECURITY'),
    ({'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Permissive'}, 'ROS_SECURITY'),
])
def test_a_misleading_environment_is_refused(ros, variables, word):
    sim = ros.start('sim', environment=variables)
    assert sim.ends() == 2
    assert word in sim.text
    assert len(sim.text.strip().splitlines()) == 1, json.dumps(sim.text)
