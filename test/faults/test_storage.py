"""Disks that are full, gone, or in the way."""

import resource
import shutil
import sys

import numpy as np
import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag

#: Wraps a node: each write to a bag takes as long as a slow disk, at most so many messages wait.
SLOW_DISK = """
import os, time
from ur5_ros.bag import writer
from ur5_ros.bag.mcap import writer as mcap_file
write = os.write
class Slow:
    def __getattr__(self, name):
        return getattr(os, name)
    def write(self, file, data):
        time.sleep(%f)
        return write(file, data)
mcap_file.os = Slow()
writer.MAX_WAITING = %d
from ur5_ros.nodes.sim_node import main
main(['sim_node', '--ros-args', '-p', 'stop_after:=1.0'])
"""


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


@pytest.mark.fault(65)
def test_a_full_disk_ends_the_recording_and_not_the_loop(ros):
    limit = 150_000
    code = (f'import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); '
            f'resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit})); '
            'from ur5_ros.nodes.sim_node import main; '
            'main(["sim_node", "--ros-args", "-p", "stop_after:=3.0"])')
    sim = ros.run([sys.executable, '-c', code])
    control = ros.start('control', bag='')
    states = ros.observer().subscribe(JointState, '/joint_states')
    assert sim.ends() == 3, sim.text
    wait_until(lambda: stamp(states[-1]) == 3_000_000_000, 'the last state')
    assert control.stop() == 0
    assert sim.text.count('messages are in no bag') == 1
    recorded = open_bag(ros.bag('sim'))
    kept = recorded.joint_states('/joint_states').stamp
    assert 0 < len(kept) < 3000
    assert not recorded.complete
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY


@pytest.mark.fault(68)
@pytest.mark.parametrize(('pause', 'waiting'), [(0.1, 1_000_000), (0.4, 300)])
def test_a_slow_disk_delays_no_node_and_what_it_cannot_store_is_counted(
        ros, pause, waiting, record_property):
    sim = ros.run([sys.executable, '-c', SLOW_DISK % (pause, waiting)])
    control = ros.start('control', bag='')
    states = ros.observer().subscribe(JointState, '/joint_states')
    code = sim.ends()
    wait_until(lambda: stamp(states[-1]) == 1_000_000_000, 'the last state')
    assert control.stop() == 0
    bag = open_bag(ros.bag('sim'))
    kept = np.unique(bag.joint_states('/joint_states').stamp)
    if code == 0:
        assert len(kept) == 1000
    else:
        assert code == 3, sim.text
        assert waiting == 300
        assert len(kept) < 1000
        assert sim.text.count('messages are in no bag') == 1
    record_property(f'states of 1000 kept by a disk of {pause:g} s a write', len(kept))


@pytest.mark.fault(65)
def test_a_folder_removed_in_the_middle_is_said_once_and_counted(ros):
    sim, control = ros.start('sim', stop_after=3.0), ros.start('control', bag='')
    states = ros.observer().subscribe(JointState, '/joint_states')
    wait_until(lambda: states and stamp(states[-1]) > 200_000_000, 'a run')
    shutil.rmtree(ros.bag('sim'))
    assert sim.ends() == 3, sim.text
    wait_until(lambda: stamp(states[-1]) == 3_000_000_000, 'the last state')
    assert control.stop() == 0


@pytest.mark.fault(65, 66)
@pytest.mark.parametrize('place', ['exists', 'file/in/the/way'])
def test_a_place_that_cannot_be_recorded_to_is_refused_before_anything_starts(ros, place):
    (ros.folder / 'exists').mkdir()
    (ros.folder / 'exists' / 'treasure').write_text('mine')
    (ros.folder / 'file').write_text('no folder')
    sim = ros.start('sim', bag=str(ros.folder / place))
    assert sim.ends() == 2
    assert 'Traceback' not in sim.text
    assert len(sim.text.strip().splitlines()) == 1, sim.text
    assert (ros.folder / 'exists' / 'treasure').read_text() == 'mine'
