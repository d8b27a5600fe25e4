"""Bags become a run; what is broken, cut, mixed or of another robot is never passed."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.fixed_messages import FixedJointState, FixedTrajectoryPoint
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.signals import JOINT_NAMES

STATES, COMMANDS = '/joint_states', '/joint_command'
JOINTS = 'sensor_msgs/msg/JointState'


def rewrite(source: Path, target: Path, change=None, description=None, note=True):
    """Write a bag again, each message of (topic, number, data) as ``change`` returns it."""
    bag = open_bag(source)
    printed = {**bag.description, **(description or {})}
    writer = BagWriter(target, {key: value for key, value in printed.items() if value is not None})
    count, topics = {}, {name: writer.topic(name, kind) for name, kind in bag.topics.items()}
    rows = []
    for name in bag.topics:
        raw = bag.columns(name)
        for i, time in enumerate(raw.log_time.tolist()):
            rows.append((time, name, raw.data[raw.offsets[i]:raw.offsets[i + 1]].tobytes()))
    for time, name, data in sorted(rows, key=lambda row: row[0]):
        number = count[name] = count.get(name, -1) + 1
        data = data if change is None else change(name, number, data)
        if data is not None:
            writer.write(topics[name], time, data)
    if note:
        writer.note('summary', bag.notes['summary'])
    writer.close()


@pytest.fixture
def copied(recorded, tmp_path):
    """Return a function that copies the run with one bag written again."""
    def copy(node, **how):
        other = 'control' if node == 'sim' else 'sim'
        target = tmp_path / 'changed'
        shutil.copytree(recorded / other, target / other)
        rewrite(recorded / node, target / node, **how)
        return target
    return copy


def failed(result):
    return [check.name for check in result.checks if check.verdict == 'fail']


def test_bags_say_the_same_as_the_loop_that_wrote_them(recorded):
    run = load_run(recorded)
    loop = as_run(run_closed_loop(run_config(duration=1.5)))
    for part in ('q', 'qd', 'effort'):
        np.testing.assert_array_equal(getattr(run.states, part), getattr(loop.states, part))
    np.testing.assert_array_equal(run.command, loop.command)
    for part in range(3):
        np.testing.assert_array_equal(run.reference[part], loop.reference[part])
    for part in loop.parts:
        np.testing.assert_array_equal(run.parts[part], loop.parts[part])
    assert run.problems == () and run.substeps == 1
    assert not failed(validate(run))


def test_a_single_bag_is_judged_as_far_as_it_goes(recorded):
    sim = validate(load_run(recorded / 'sim'))
    assert sim.check('residual, simulator arm').verdict == 'pass'
    assert sim.check('error step').verdict == 'not applicable'
    control = validate(load_run(recorded / 'control', arm='ur5'))
    assert control.check('inverse dynamics').verdict == 'pass'
    assert control.check('recording').verdict == 'pass'


def test_the_missing_half_of_a_run_fails(recorded, tmp_path):
    shutil.copytree(recorded / 'sim', tmp_path / 'run' / 'sim')
    result = validate(load_run(tmp_path / 'run'))
    assert failed(result) == ['recording']
    assert 'control node is missing' in result.check('recording').sentence


@pytest.mark.fault(77)
def test_bags_of_two_runs_are_refused(copied):
    folder = copied('control', description={'run': 'another'})
    with pytest.raises(InputError, match='another.*put the bags of one run together'):
        load_run(folder)


def test_a_run_cut_short_is_judged_to_its_last_whole_record(copied):
    folder = copied('control', note=False, change=lambda topic, number, data:
                    data if number < 700 else None)
    result = validate(load_run(folder))
    assert result.about['states'] == 700
    assert failed(result) == ['recording']
    assert 'not closed' in result.check('recording').sentence


def test_a_cut_file_is_judged_to_its_last_whole_record(recorded, tmp_path):
    target = tmp_path / 'cut'
    shutil.copytree(recorded, target)
    file = next((target / 'control').glob('*.mcap'))
    file.write_bytes(file.read_bytes()[:file.stat().st_size * 2 // 3])
    result = validate(load_run(target))
    assert 100 < result.about['states'] < 1500
    assert failed(result) == ['recording']


def test_what_is_no_number_ends_what_is_judged_and_fails(copied):
    codec = FixedJointState(JOINT_NAMES)

    def spoil(topic, number, data):
        if topic == STATES and number == 400:
            stamp, q, qd, effort = codec.decode(data)
            return codec.encode(stamp, q, np.where(np.arange(6) == 2, np.nan, qd), effort)
        return data

    result = validate(load_run(copied('sim', change=spoil)))
    assert result.about['states'] == 400
    assert 'not a number' in result.check('recording').sentence
    assert failed(result) == ['recording']
    json.loads(result.to_json())


@pytest.mark.fault(76)
def test_two_publishers_mixed_into_one_topic_fail(copied):
    codec, last = FixedJointState(JOINT_NAMES), {}

    def mix(topic, number, data):
        if topic == STATES and number == 500:
            stamp = codec.decode(last['data'])[0]
            _, q, qd, effort = codec.decode(data)
            return codec.encode(stamp, q + 1.0, qd, effort)
        if topic == STATES:
            last['data'] = data
        return data

    result = validate(load_run(copied('sim', change=mix)))
    assert 'repeats a stamp with other numbers' in result.check('recording').sentence
    assert 'timing' in failed(result)


@pytest.mark.fault(76)
def test_lost_states_and_commands_are_counted(copied):
    folder = copied('control', change=lambda topic, number, data:
                    None if topic == COMMANDS and number in (30, 31, 700) else data)
    result = validate(load_run(folder))
    check = result.check('pairing')
    assert check.verdict == 'fail' and check.value == 3
    assert 'the first without is state 31' in check.sentence
    assert result.check('error step').verdict == 'pass'


def test_answers_to_states_that_are_not_recorded_fail(copied):
    folder = copied('sim', change=lambda topic, number, data:
                    None if topic == STATES and number == 30 else data)
    result = validate(load_run(folder))
    assert '1 answer belongs to no recorded state' in result.check('pairing').sentence
    assert result.check('timing').verdict == 'fail'
    assert result.check('residual, simulator arm').verdict == 'pass'


def test_joints_in_another_order_are_matched_by_name(copied):
    codec = FixedJointState(JOINT_NAMES)
    order = [2, 0, 1, 5, 4, 3]
    other = FixedJointState([JOINT_NAMES[i] for i in order])

    def shuffle(topic, number, data):
        if topic != STATES:
            return data
        stamp, *fields = codec.decode(data)
        return other.encode(stamp, *(field[order] for field in fields))

    assert not failed(validate(load_run(copied('sim', change=shuffle))))


def test_a_bag_of_another_robot_is_refused(tmp_path):
    names = [f'panda_joint{i}' for i in range(1, 7)]
    codec = FixedJointState(names)
    with BagWriter(tmp_path / 'panda', {}) as writer:
        topic = writer.topic(STATES, JOINTS)
        for k in range(1, 50):
            writer.write(topic, k, codec.encode(k * 1000, np.zeros(6), np.zeros(6), np.zeros(6)))
    with pytest.raises(InputError, match='panda_joint1.*needed are shoulder_pan_joint'):
        load_run(tmp_path / 'panda')


def test_joint_states_of_another_type_are_refused(recorded, tmp_path):
    bag = open_bag(recorded / 'sim')
    with BagWriter(tmp_path / 'bad', bag.description) as writer:
        topic = writer.topic(STATES, 'trajectory_msgs/msg/JointTrajectory')
        writer.write(topic, 1, FixedTrajectoryPoint(JOINT_NAMES).encode(
            1, *[np.zeros(6)] * 4))
    with pytest.raises(InputError, match='is trajectory_msgs'):
        load_run(tmp_path / 'bad')


@pytest.mark.parametrize('key, value', [
    ('parameters', '{'), ('parameters', '[]'), ('arm', 'name: x'), ('topics', '3'),
    ('parameters', '{"control_rate": -5}'), ('parameters', '{"kp": [NaN]}')])
def test_a_damaged_description_is_refused(copied, key, value):
    with pytest.raises(InputError):
        load_run(copied('sim', description={key: value}))


def test_states_without_positions_and_too_few_states_are_refused(tmp_path):
    codec = FixedJointState(JOINT_NAMES, fields=('effort',))
    with BagWriter(tmp_path / 'effort', {}) as writer:
        topic = writer.topic(STATES, JOINTS)
        for k in range(1, 5):
            writer.write(topic, k, codec.encode(k * 1000, (), (), np.zeros(6)))
    with pytest.raises(InputError, match='no position'):
        load_run(tmp_path / 'effort')
    with BagWriter(tmp_path / 'one', {}) as writer:
        topic = writer.topic(STATES, JOINTS)
        writer.write(topic, 1, FixedJointState(JOINT_NAMES).encode(1, *[np.zeros(6)] * 3))
    with pytest.raises(InputError, match='at least two'):
        load_run(tmp_path / 'one')
    with pytest.raises(InputError, match='no such folder'):
        load_run(tmp_path / 'absent')


def test_one_folder_of_ros2_bag_record_is_read_with_what_the_user_says(recorded, tmp_path):
    bags = [open_bag(recorded / node) for node in ('sim', 'control')]
    with BagWriter(tmp_path / 'mixed', {}) as writer:
        done = set()
        for bag in bags:
            for name, kind in bag.topics.items():
                if name in done or kind not in (JOINTS, 'trajectory_msgs/msg/JointTrajectory'):
                    continue
                raw = bag.columns(name)
                if not len(raw.log_time):
                    continue
                done.add(name)
                topic = writer.topic(name, kind)
                for i in range(len(raw.log_time)):
                    writer.write(topic, int(raw.log_time[i]),
                                 raw.data[raw.offsets[i]:raw.offsets[i + 1]].tobytes())
    result = validate(load_run(tmp_path / 'mixed', control_arm='ur5', kp=[10.0], kd=[10.0]))
    assert result.check('inverse dynamics').verdict == 'pass'
    assert result.check('pairing').verdict == 'pass'
    assert result.check('gains').verdict == 'pass'
    wrong = validate(load_run(tmp_path / 'mixed', arm='ur5e'))
    assert wrong.check('inverse dynamics').verdict == 'fail'
