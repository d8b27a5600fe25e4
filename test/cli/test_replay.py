"""A recording replayed: the messages of the bag, in their order, byte for byte."""

import sys

import pytest
from ros_processes import ros_domain, wait_until
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from ur5_ros.bag.reader import open_bag


@pytest.fixture
def ros(tmp_path):
    with ros_domain(tmp_path) as domain:
        yield domain


def replay(ros, *arguments):
    """Start ``ur5 replay`` in the domain of the test."""
    code = 'from ur5_ros.cli import main; main()'
    return ros.run([sys.executable, '-c', code, 'replay', *map(str, arguments)])


def stamp(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def test_replay_sends_every_message_of_a_part_in_order_on_a_busy_machine(ros, short_run):
    """The first and the last ones were lost: neither side waited for the other."""
    for _ in range(3):
        ros.run([sys.executable, '-c', 'while True: pass'])
    observer = ros.observer()
    received = observer.subscribe(JointState, '/joint_states', publishers=0)
    references = observer.subscribe(JointTrajectory, '/ur5_control/reference', publishers=0)
    process = replay(ros, short_run, '--start', 0.2, '--stop', 0.7, '--rate', 2.0,
                     '--topics', '/joint_states', '--topics', '/ur5_control/reference')
    assert process.ends() == 0, process.text
    wait_until(lambda: len(received) >= 501 and len(references) >= 501, 'all messages')
    recorded = open_bag(short_run / 'sim').joint_states('/joint_states')
    assert [stamp(message) for message in received] == recorded.stamp[200:701].tolist()
    assert list(received[0].position) == recorded.position[200].tolist()
    assert len(references) == 501
    assert '1002 messages sent on' in process.text


def test_replay_drives_the_clock_unless_no_clock_is_given(ros, short_run):
    observer = ros.observer()
    ticks = observer.subscribe(Clock, '/clock', publishers=0)
    states = observer.subscribe(JointState, '/joint_states', publishers=0)
    silent = replay(ros, short_run, '--rate', 20, '--no-clock')
    assert silent.ends() == 0 and len(states) > 0, silent.text
    assert ticks == []
    loud = replay(ros, short_run, '--rate', 5, '--topics', '/clock')
    assert loud.ends() == 0, loud.text
    wait_until(lambda: ticks, 'the clock')
    times = [tick.clock.sec * 1_000_000_000 + tick.clock.nanosec for tick in ticks]
    assert times == sorted(times) and times[-1] <= 1_500_000_000


def test_replay_in_a_loop_goes_on_until_interrupted(ros, short_run):
    received = ros.observer().subscribe(JointState, '/joint_states', publishers=0)
    process = replay(ros, short_run, '--loop', '--rate', 10, '--topics', '/joint_states')
    wait_until(lambda: sum(stamp(m) == 1_000_000 for m in received) >= 2, 'the second round')
    assert process.stop() == 130
    assert process.text.strip().endswith('ur5: interrupted')


@pytest.mark.parametrize(('arguments', 'named'), [
    (('--rate', '0'), '--rate'), (('--rate', '-1'), '--rate'), (('--rate', 'nan'), '--rate'),
    (('--topics', '/nothing'), '/nothing'), (('--start', '99'), '99'),
])
def test_a_replay_of_nothing_is_refused(ur5, short_run, arguments, named):
    refused = ur5('replay', short_run, *arguments)
    assert refused.code == 2 and named in refused.err and refused.err.count('\n') == 1
    assert refused.out == ''
