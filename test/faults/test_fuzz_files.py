"""Mutilated YAML files and bags: one line that names what is wrong, or read as what they are."""

import random

import numpy as np
import pytest

from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.recovery import recover
from ur5_ros.bag.rosbag2_folder import BagFolder, make_topic
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.cdr.recorded_types import schema_text
from ur5_ros.config import arm_text, config_folder, parse_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.parameter_files import require_sections
from ur5_ros.config.validation import load_marks
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sweep.spec import parse_sweep

JOINT_STATE = 'sensor_msgs/msg/JointState'


@pytest.mark.timeout(3600)
@pytest.mark.fault(31, 38, 39, 40, 41, 42, 44, 45)
def test_no_mutilated_file_gets_past_its_reader(times, tmp_path, record_property):
    dice = random.Random(4)
    config, path = config_folder(), tmp_path / 'fuzz.yaml'
    sweep = sorted((config / 'sweeps').glob('*.yaml'))[0].read_text()

    def parameters(text):
        path.write_text(text)
        require_sections([path], '/ur5_sim')

    def from_file(read):
        def written(text):
            path.write_text(text)
            read(str(path))
        return written

    readers = [
        (arm_text('ur5'), lambda text: parse_arm(text, 'fuzz.yaml')),
        ((config / 'experiments' / 'kebria_fig11.yaml').read_text(), from_file(load_experiment)),
        ((config / 'sim.yaml').read_text(), parameters),
        ((config / 'validation.yaml').read_text(), from_file(load_marks)),
        (sweep, lambda text: parse_sweep(text, 'fuzz.yaml')),
    ]
    tried = refused = 0
    for _ in range(times(80, 2_000)):
        for text, read in readers:
            tried += 1
            try:
                read(mutilate(text, dice))
            except InputError as refusal:
                assert '\n' not in str(refusal)
                refused += 1
    record_property('mutilated YAML files', tried)
    assert refused > tried // 3


def mutilate(text: str, dice: random.Random) -> str:
    """Return a text with characters, numbers or lines changed."""
    for _ in range(dice.choice([1, 1, 2, 4])):
        kind = dice.randrange(5)
        lines = text.splitlines(keepends=True)
        where = dice.randrange(len(lines))
        if kind == 0:
            del lines[where]
        elif kind == 1:
            lines.insert(where, lines[dice.randrange(len(lines))])
        elif kind == 2:
            other = dice.choice(['.nan', '-1', '1e999', 'x', '&a '])
            lines[where] = lines[where].replace('0', other)
        elif kind == 3:
            lines[where] = lines[where][:dice.randrange(len(lines[where]) + 1)]
        else:
            head = dice.choice(['{', '- ', '!!python/object:os.system ', '? ', '\t'])
            lines[where] = head + lines[where]
        text = ''.join(lines) or '\n'
    return text


@pytest.mark.timeout(3600)
@pytest.mark.fault(69, 70, 71, 73)
def test_no_mutilated_bag_is_read_as_whole(times, tmp_path, record_property):
    dice = random.Random(5)
    whole = small_bag(tmp_path / 'whole').read_bytes()
    folder = tmp_path / 'fuzz'
    folder.mkdir()
    path = folder / 'fuzz.mcap'
    path.write_bytes(whole)
    truth = {tuple(row) for row in rows_of(path)[0]}
    count, refused, mended = times(300, 10_000), 0, 0
    for number in range(count):
        path.write_bytes(spoilt(whole, dice))
        try:
            rows, problems = rows_of(path)
            assert all('\n' not in problem for problem in problems)
            assert problems or {tuple(row) for row in rows} == truth
            if problems and number % 10 == 0:
                mended += recover(path, tmp_path / f'mended_{number}').out is not None
        except InputError as refusal:
            assert '\n' not in str(refusal)
            refused += 1
    record_property('mutilated bags', count)
    record_property('mutilated bags refused as a whole', refused)
    assert mended > 0


def small_bag(folder):
    """Write a finished bag of forty joint states in eight chunks and return its file."""
    codec, rng = FixedJointState(JOINT_NAMES), np.random.default_rng(5)
    bag = BagFolder(folder, 'small', {'run': 'r'})
    bag.topics.append(make_topic(1, 1, '/joint_states',
                                 (JOINT_STATE, schema_text(JOINT_STATE).encode()),
                                 [qos_profile()], 'RIHS01_00'))
    for begin in range(0, 40, 5):
        bag.write([(1, k, k, codec.encode(k, *rng.normal(size=(3, 6))))
                   for k in range(begin + 1, begin + 6)])
    bag.finish()
    return next(folder.glob('*.mcap'))


def rows_of(path):
    """Return the joint states that a reader gets out of a bag, and what it says is wrong."""
    bag = open_bag(path)
    if '/joint_states' not in bag.topics:
        return [], [*bag.problems, 'no states']
    states = bag.joint_states('/joint_states')
    rows = np.column_stack([states.stamp, states.position, states.velocity, states.effort])
    return rows.tolist(), bag.problems


def spoilt(data: bytes, dice: random.Random) -> bytes:
    """Return a file with bits flipped, bytes overwritten, pieces missing, doubled or moved."""
    data = bytearray(data)
    for _ in range(dice.choice([1, 1, 2, 8])):
        kind, at = dice.randrange(6), dice.randrange(len(data))
        length = dice.choice([1, 8, 60, 700])
        if kind == 0:
            data[at] ^= 1 << dice.randrange(8)
        elif kind == 1:
            data[at:at + 8] = dice.choice([2**40, 2**63, 0, 3 * 2**30]).to_bytes(8, 'little')
        elif kind == 2:
            data[at:at + length] = dice.randbytes(length)
        elif kind == 3:
            del data[at:at + length]
        elif kind == 4:
            data[at:at] = data[at:at + length]
        else:
            data = data[:max(at, 1)]
    return bytes(data)
