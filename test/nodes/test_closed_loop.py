"""Two processes over Fast DDS in lockstep: the same bits, whoever starts first."""

import json
import sys

from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag

#: A short run with a motion in it.
SHORT = {'stop_after': 0.5, 'initial_positions': [0.1, -1.4, 1.3, -1.2, -1.4, 0.2]}


def run_pair(ros, first='control', sim=None, control=None, between=lambda: None):
    """Run both nodes to the end; return the summaries of both bags."""
    parameters = {'sim': SHORT | (sim or {}),
                  'control': {'experiment': 'joint_step', 'autostart': True} | (control or {})}
    second = 'sim' if first == 'control' else 'control'
    nodes = {first: ros.start(first, **parameters[first])}
    between()
    nodes[second] = ros.start(second, **parameters[second])
    assert nodes['sim'].ends() == 0, nodes['sim'].text
    assert nodes['control'].stop() == 0, nodes['control'].text
    return {node: summary(ros, node) for node in nodes}


def summary(ros, node):
    """Return the summary of the newest bag of a node."""
    folder = max((ros.folder / 'bags').glob(f'*/{node}'), key=lambda path: path.stat().st_mtime)
    bag = open_bag(folder)
    assert bag.complete
    assert not bag.problems
    return {key: json.loads(value) if isinstance(value, str) and value[:1] in '{[' else value
            for key, value in bag.notes['summary'].items()}


def test_a_run_repeats_to_the_last_bit_whichever_node_starts_first(ros):
    first = run_pair(ros)
    states = ros.observer().subscribe(JointState, '/joint_states', publishers=0)
    second = run_pair(ros, first='sim', between=lambda: wait_until(
        lambda: len(states) > 3, 'copies of state 1'))
    assert first['sim']['hashes'] == second['sim']['hashes']
    assert first['control']['hashes'] == second['control']['hashes']
    assert first['sim']['hashes']['joint_states'] == first['control']['hashes']['joint_states']
    assert first['sim']['periods'] == 500


def test_a_busy_machine_changes_no_bit(ros):
    quiet = run_pair(ros)
    for _ in range(3):
        ros.run([sys.executable, '-c', 'while True: pass'])
    busy = run_pair(ros)
    assert quiet['sim']['hashes'] == busy['sim']['hashes']
    assert quiet['control']['hashes'] == busy['control']['hashes']


def test_the_plain_executor_gives_the_same_bits(ros):
    hot = run_pair(ros)
    plain = run_pair(ros, sim={'hot_loop': 'executor'}, control={'hot_loop': 'executor'})
    assert hot['sim']['hashes'] == plain['sim']['hashes']
    assert hot['control']['hashes'] == plain['control']['hashes']


def test_both_bags_hold_the_run_once_and_belong_together(ros):
    run_pair(ros)
    sim, control = open_bag(ros.bag('sim')), open_bag(ros.bag('control'))
    assert sim.description['run'] == control.description['run'] == ros.bag('sim').parent.name
    stamps = [1_000_000 * k for k in range(1, 501)]
    assert sim.joint_states('/joint_states').stamp.tolist() == stamps
    assert control.joint_states('/joint_states').stamp.tolist() == stamps
    assert control.joint_states('/joint_command').stamp.tolist() == stamps
    assert sim.joint_states('/joint_command').stamp.tolist() == stamps[:-1]
