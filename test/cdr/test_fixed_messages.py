"""Our CDR bytes against those of rosbags and rclpy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from ur5_ros.cdr.codec import definitions_of
from ur5_ros.cdr.fixed_messages import (
    FixedJointState,
    FixedPose,
    FixedTrajectoryPoint,
    decode,
    decode_clock,
    encode,
    encode_clock,
    encode_string,
)
from ur5_ros.cdr.message_definition import PRIMITIVES
from ur5_ros.cdr.recorded_types import DEFINITIONS
from ur5_ros.errors import BagError
from ur5_ros.signals import JOINT_NAMES

STORE = get_typestore(Stores.ROS2_JAZZY)
RANGES = {'i1': (-2**7, 2**7 - 1), 'u1': (0, 2**8 - 1), 'i2': (-2**15, 2**15 - 1),
          'u2': (0, 2**16 - 1), 'i4': (-2**31, 2**31 - 1), 'u4': (0, 2**32 - 1),
          'i8': (-2**63, 2**63 - 1), 'u8': (0, 2**64 - 1)}
TEXTS = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=12)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)
SIX = st.lists(st.floats(width=64), min_size=6, max_size=6).map(np.array)


def values_of(type_name, definitions):
    """Return a strategy for messages of a type, as dicts."""
    parts = {}
    for field in definitions[type_name]:
        if field.nested:
            single = values_of(field.base, definitions)
        elif PRIMITIVES[field.base] is None:
            single = TEXTS
        elif field.base == 'bool':
            single = st.booleans()
        elif field.base == 'byte':
            single = st.integers(0, 127)  # rosbags takes it for a signed number
        elif PRIMITIVES[field.base].startswith('f'):
            single = st.floats(width=8 * int(PRIMITIVES[field.base][1]))
        else:
            single = st.integers(*RANGES[PRIMITIVES[field.base]])
        parts[field.name] = st.lists(single, max_size=4) if field.array else single
    return st.fixed_dictionaries(parts)


MESSAGES = st.sampled_from(sorted(DEFINITIONS)).flatmap(
    lambda name: st.tuples(st.just(name), values_of(name, definitions_of(name))))


def equal(one, other):
    """Return whether two messages are the same, NaN equal to NaN."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, (list, np.ndarray)):
        return len(one) == len(other) and all(map(equal, list(one), list(other)))
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    return one == other


def with_rosbags(name, value, definitions):
    """Return a dict as a message object of rosbags."""
    fields = {}
    for field in definitions[name]:
        given_value = value[field.name]
        if field.nested:
            given_value = [with_rosbags(field.base, each, definitions) for each in given_value] \
                if field.array else with_rosbags(field.base, given_value, definitions)
        elif field.array and PRIMITIVES[field.base]:
            given_value = np.array(given_value, PRIMITIVES[field.base])
        fields[field.name] = given_value
    return STORE.types[name](**fields)


@settings(max_examples=300, deadline=None)
@given(MESSAGES)
def test_every_recorded_type_is_encoded_as_rosbags_encodes_it_and_read_back(message):
    name, value = message
    definitions = definitions_of(name)
    theirs = with_rosbags(name, value, definitions)
    ours = encode(name, value)
    assert bytes(STORE.serialize_cdr(theirs, name)) == ours
    assert equal(decode(name, ours), value)
    swapped = bytes(STORE.serialize_cdr(theirs, name, little_endian=False))
    assert equal(decode(name, swapped), value)


@settings(max_examples=200, deadline=None)
@given(STAMPS, SIX, SIX, SIX, TEXTS)
def test_the_fixed_joint_state_equals_the_general_codec_and_comes_back(
        stamp, position, velocity, effort, frame):
    codec = FixedJointState(JOINT_NAMES, frame)
    data = codec.encode(stamp, position, velocity, effort)
    seconds, nanoseconds = divmod(stamp, 10**9)
    assert data == encode('sensor_msgs/msg/JointState', {
        'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds}, 'frame_id': frame},
        'name': JOINT_NAMES, 'position': position, 'velocity': velocity, 'effort': effort})
    assert len(data) == codec.size and codec.matches(data)
    back = codec.decode(data)
    assert back[0] == stamp
    for one, other in zip(back[1:], (position, velocity, effort), strict=True):
        assert one.tobytes() == other.tobytes()


def test_a_joint_state_of_six_joints_has_316_bytes():
    assert FixedJointState(JOINT_NAMES).size == 316


def test_a_command_leaves_position_and_velocity_empty():
    codec = FixedJointState(JOINT_NAMES, fields=('effort',))
    data = codec.encode(7, effort=np.arange(6.0))
    read = decode('sensor_msgs/msg/JointState', data)
    assert len(read['position']) == len(read['velocity']) == 0
    assert read['effort'].tolist() == [0, 1, 2, 3, 4, 5]
    stamp, position, velocity, effort = codec.decode(data)
    assert (stamp, len(position), len(velocity), effort.tolist()) == (7, 0, 0, [0, 1, 2, 3, 4, 5])


def test_lists_and_other_number_types_are_encoded_alike():
    codec = FixedJointState(JOINT_NAMES)
    whole = np.arange(6)
    assert codec.encode(1, whole, whole.astype('f4'), whole.tolist()) \
        == codec.encode(1, *[whole.astype(float)] * 3)


@pytest.mark.parametrize('number', [0, 5, 7])
def test_a_wrong_number_of_values_is_refused(number):
    six = np.zeros(6)
    with pytest.raises(ValueError, match='has 6' if number == 6 else f'has {number} numbers'):
        FixedJointState(JOINT_NAMES).encode(1, six, np.zeros(number), six)


@pytest.mark.parametrize('names', [
    JOINT_NAMES[::-1], JOINT_NAMES[:5], (*JOINT_NAMES[:5], 'wrist_4_joint'), (*JOINT_NAMES, 'x')])
def test_other_names_or_another_order_do_not_match(names):
    data = FixedJointState(names).encode(1, *[np.zeros(len(names))] * 3)
    assert not FixedJointState(JOINT_NAMES).matches(data)


def test_padding_that_another_writer_left_uninitialised_is_ignored():
    codec = FixedJointState(JOINT_NAMES)
    data = bytearray(codec.encode(1, *[np.arange(6.0)] * 3))
    compared = np.frombuffer(codec.layout.mask, np.uint8) != 0
    for offset, _, number in codec.layout.slots.values():
        compared[offset:offset + 8 * number] = True
    padding = np.flatnonzero(~compared[4:]) + 4
    assert len(padding) > 4
    for at in padding:
        data[at] = 0xA5
    assert codec.matches(bytes(data))
    assert decode('sensor_msgs/msg/JointState', bytes(data))['name'] == list(JOINT_NAMES)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 315), st.integers(1, 255)), min_size=1, max_size=20))
def test_many_messages_are_compared_as_one_is(changes):
    codec = FixedJointState(JOINT_NAMES)
    good = np.frombuffer(codec.encode(1, *[np.arange(6.0)] * 3), np.uint8)
    rows = np.repeat(good[None], len(changes) + 1, axis=0)
    for row, (at, change) in zip(rows, changes, strict=False):
        row[at] ^= change
    assert codec.layout.fits(rows).tolist() == [codec.matches(row.tobytes()) for row in rows]


def test_the_fixed_trajectory_point_equals_the_general_codec_and_comes_back():
    codec = FixedTrajectoryPoint(JOINT_NAMES)
    parts = np.random.default_rng(1).normal(size=(4, 6))
    data = codec.encode(3_000_000_004, *parts)
    assert data == encode('trajectory_msgs/msg/JointTrajectory', {
        'header': {'stamp': {'sec': 3, 'nanosec': 4}}, 'joint_names': JOINT_NAMES,
        'points': [dict(zip(codec.FIELDS, parts, strict=True))]})
    stamp, *back = codec.decode(data)
    assert codec.matches(data) and stamp == 3_000_000_004 and np.array_equal(back, parts)


def test_pose_clock_and_string_equal_the_general_codec():
    pose = FixedPose('base')
    data = pose.encode(5, [1, 2, 3], [0, 0, 0, 1])
    assert data == encode('geometry_msgs/msg/PoseStamped', {
        'header': {'stamp': {'nanosec': 5}, 'frame_id': 'base'},
        'pose': {'position': {'x': 1, 'y': 2, 'z': 3}, 'orientation': {'w': 1}}})
    stamp, position, turn = pose.decode(data)
    assert (stamp, position.tolist(), turn.tolist()) == (5, [1, 2, 3], [0, 0, 0, 1])
    clock = encode_clock(12_000_000_034)
    assert clock == encode('rosgraph_msgs/msg/Clock', {'clock': {'sec': 12, 'nanosec': 34}})
    assert decode_clock(clock) == 12_000_000_034
    assert encode_string('hä') == encode('std_msgs/msg/String', {'data': 'hä'})


def test_rclpy_reads_what_the_fixed_codecs_write_and_the_other_way_round():
    serialization = pytest.importorskip('rclpy.serialization')
    from sensor_msgs.msg import JointState
    codec = FixedJointState(JOINT_NAMES)
    parts = np.random.default_rng(2).normal(size=(3, 6))
    message = serialization.deserialize_message(codec.encode(1_000_000_002, *parts), JointState)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 2)
    assert tuple(message.name) == JOINT_NAMES
    assert np.array_equal([message.position, message.velocity, message.effort], parts)
    theirs = bytes(serialization.serialize_message(message))
    assert codec.matches(theirs)
    stamp, *back = codec.decode(theirs)
    assert stamp == 1_000_000_002 and np.array_equal(back, parts)


@pytest.mark.fault(73)
@settings(max_examples=200, deadline=None)
@given(MESSAGES, st.data())
def test_changed_bytes_never_do_worse_than_a_named_problem(message, data):
    name, value = message
    raw = bytearray(encode(name, value))
    for _ in range(data.draw(st.integers(1, 4))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    raw = raw[:data.draw(st.integers(0, len(raw)))]
    try:
        decode(name, bytes(raw))
    except BagError as problem:
        assert '\n' not in str(problem)


@pytest.mark.fault(73)
@settings(max_examples=500, deadline=None)
@given(st.sampled_from(sorted(DEFINITIONS)), st.binary(max_size=200))
def test_random_bytes_never_do_worse_than_a_named_problem(name, raw):
    try:
        decode(name, b'\0\1\0\0' + raw)
    except BagError as problem:
        assert '\n' not in str(problem)


@pytest.mark.fault(73)
@pytest.mark.parametrize('raw', [
    b'', b'\0\1', b'\0\6\0\0' + bytes(40), b'\1\1\0\0' + bytes(40),
    b'\0\1\0\0' + bytes(8) + b'\xff\xff\xff\xff' + bytes(100),
    b'\0\1\0\0' + bytes(8) + b'\2\0\0\0\xff\0' + bytes(100),
    b'\0\1\0\0' + bytes(8) + b'\1\0\0\0\0\0\0\0' + b'\xff\xff\xff\x7f' + bytes(100)])
def test_hostile_bytes_are_named(raw):
    with pytest.raises(BagError):
        decode('sensor_msgs/msg/JointState', raw)


def test_an_unknown_field_and_a_number_that_does_not_fit_are_refused():
    with pytest.raises(ValueError, match='no field'):
        encode('std_msgs/msg/String', {'text': 'x'})
    with pytest.raises(ValueError):
        encode('builtin_interfaces/msg/Time', {'sec': 2**31})
