"""Either node is ended and started again, in any order: the other one goes on with it."""

import os
import random
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from thorough import THOROUGH

from ur5_ros.bag.reader import open_bag

#: Wall time from "ready" to the first command that answers the simulator in charge [s].
LONGEST_TAKEOVER = 0.6
#: A node that restarts, or whose partner does, says this much at most.
MOST_LINES = 8
RATES = (50, 125, 250, 500, 1000)


class Restarts:
    """Two nodes, one of which is started again at a time."""

    def __init__(self, ros, lockstep: bool) -> None:
        self.ros, self.lockstep = ros, lockstep
        self.random = random.Random(lockstep)
        self.watcher = ros.observer()
        self.states, self.commands = [], []
        self.took: list[float] = []
        self.nodes = {'sim': self.start('sim'), 'control': self.start('control')}
        self.watcher.subscribe(JointState, '/joint_states', react=self.states.append)
        self.watcher.subscribe(JointState, '/joint_command', react=self.commands.append)
        self.wait_for_answers()

    def start(self, name: str):
        """Start a node and wait until it is ready."""
        if name == 'sim':
            node = self.ros.start(
                'sim', lockstep=self.lockstep, control_rate=self.random.choice(RATES),
                physics_rate=1000, realtime_factor=1.0)
            node.wait_for_line('recorded in')
        else:
            node = self.ros.start('control')
            node.wait_for_line('waiting for states')
        return node

    def wait_for_answers(self) -> None:
        """Wait until five further states have been answered, and the controller records them."""
        answered = len(self.commands)
        began = time.monotonic()
        wait_until(lambda: len(self.commands) > answered, 'a command')
        self.took.append(time.monotonic() - began)
        wait_until(lambda: len(self.commands) > answered + 5, 'five more')
        starts = len(self.ros.processes)
        wait_until(lambda: len(self.folders('control')) == starts - 1,
                   'a folder of the controller for each start but the first simulator')

    def folders(self, node: str) -> list[Path]:
        """Return the folders that a node, or one in its place, has recorded into."""
        return sorted((self.ros.folder / 'bags').glob(f'*/{node}*'))

    def restart(self) -> None:
        """End one node, by a signal that asks or by one that does not, and start it again."""
        name = self.random.choice(('sim', 'control'))
        time.sleep(self.random.uniform(0.0, 0.3))
        if self.random.random() < 0.5:
            self.nodes[name].kill()
        else:
            assert self.nodes[name].stop(signal.SIGTERM) == 0, self.nodes[name].text
        self.nodes[name] = self.start(name)
        self.wait_for_answers()

    def lines(self) -> int:
        """Return how many lines all nodes have logged."""
        return sum(len(node.text.splitlines()) for node in self.ros.processes)


@pytest.mark.timeout(3600)
@pytest.mark.parametrize('lockstep', [True, False], ids=['lockstep', 'paced'])
def test_a_restart_of_either_node_is_followed(ros, lockstep, times, record_property):
    number = times(10, 100)
    pair = Restarts(ros, lockstep)
    for _ in range(number):
        pair.restart()
    for node in pair.nodes.values():
        assert node.stop() == 0, node.text
    record_property('restarts', number)
    record_property('takeover, worst [s]', max(pair.took))
    record_property('takeover, median [s]', float(np.median(pair.took)))
    if THOROUGH:  # `make test` asserts no times
        busy = os.getloadavg()[0] > 2.0 * (os.cpu_count() or 1)
        assert max(pair.took) < LONGEST_TAKEOVER * (3.0 if busy else 1.0), pair.took
    # the arm is held all the time
    start = pair.states[0]
    assert max(max(map(abs, state.velocity)) for state in pair.states) < 0.05
    assert max(np.abs(np.subtract(state.position, start.position)).max()
               for state in pair.states) < 0.02
    assert pair.lines() <= MOST_LINES * (number + 2)
    assert not any('keep one of them' in node.text for node in ros.processes), 'one was killed'
    simulators = pair.folders('sim')
    assert len(simulators) == sum('recorded in' in node.text for node in ros.processes)
    for bag in [*simulators, *pair.folders('control')]:
        assert open_bag(bag).topics
