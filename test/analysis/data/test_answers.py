"""Commands without a stamp find their states by order, as far as lockstep makes it certain."""

import numpy as np

from ur5_ros.analysis.data.answers import pair_by_order
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.series import efforts_of_arrays
from ur5_ros.bag.arrays.columns import RawColumns
from ur5_ros.bag.reader import open_bag
from ur5_ros.cdr.codec import encode


def golden(repo):
    """Return the run of two real nodes, and what the simulator recorded of states and commands."""
    bag = open_bag(repo / 'bags/golden/sim')
    columns = bag.load({'/joint_states': None, '/joint_command': None})
    return load_run(repo / 'bags/golden'), columns['/joint_states'], columns['/joint_command']


def test_the_order_of_a_recording_gives_the_same_pairs_as_its_stamps(repo):
    run, states, commands = golden(repo)
    paired = pair_by_order(states, run.stamp, commands.log_time, commands.effort)
    np.testing.assert_array_equal(paired[:-1], run.command[:-1])


def test_two_commands_for_one_state_are_not_paired(repo):
    run, states, commands = golden(repo)
    log_time = commands.log_time.copy()
    log_time[101] = log_time[100]
    assert pair_by_order(states, run.stamp, log_time, commands.effort) is None


def test_copies_of_the_first_state_and_early_commands_do_no_harm(repo):
    run, states, commands = golden(repo)
    log_time = np.concatenate([states.log_time[:1] - 10, states.log_time[:1], commands.log_time])
    efforts = np.concatenate([commands.effort[:2] + 1.0, commands.effort])
    paired = pair_by_order(states, run.stamp, log_time, efforts)
    np.testing.assert_array_equal(paired[:-1], run.command[:-1])


def test_six_numbers_are_read_from_each_array():
    data = [encode('std_msgs/msg/Float64MultiArray',
                   {'layout': {'dim': [], 'data_offset': 0}, 'data': list(values)})
            for values in ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), (1.0, 2.0))]
    offsets = np.cumsum([0, *map(len, data)])
    raw = RawColumns(np.arange(2), np.arange(2), np.frombuffer(b''.join(data), np.uint8), offsets)
    efforts = efforts_of_arrays(raw)
    assert efforts[0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert np.isnan(efforts[1]).all()
