"""MCAP files of other writers, and sqlite3 bags: judged and replayed, or named in one line."""

import numpy as np
import pytest
from foreign_recordings import arm_messages, gripper_messages, motion
from mcap.writer import Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.playback import load_playback
from ur5_ros.cdr.codec import decode, encode
from ur5_ros.cdr.message_definition import parse_schema
from ur5_ros.cdr.recorded_types import SEPARATOR, schema_text
from ur5_ros.errors import InputError

JOINT_STATE = 'sensor_msgs/msg/JointState'
TEXT = schema_text(JOINT_STATE)
SEQUENCE = TEXT.replace('MSG: std_msgs/Header\n', 'MSG: std_msgs/Header\nuint32 seq\n')


@pytest.fixture(scope='module')
def made():
    return motion()


def write(path, messages, name=JOINT_STATE, form='ros2msg', text=TEXT, encoding='cdr',
          profile='ros2'):
    """Write messages of /joint_states as another writer would."""
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start(profile=profile, library='another writer')
        schema = 0 if name is None else writer.register_schema(name, form, text.encode())
        channel = writer.register_channel('/joint_states', encoding, schema)
        for time, data in messages:
            writer.add_message(channel, time, data, time)
        writer.finish()
    return path


def with_sequence(messages):
    """Return messages with a sequence number, as bridges from ROS 1 leave them."""
    definitions = parse_schema(JOINT_STATE, SEQUENCE)
    return [(time, encode(JOINT_STATE, decode(JOINT_STATE, data), definitions))
            for time, data in messages]


READABLE = {
    'the old name of the type': {'name': 'sensor_msgs/JointState'},
    'an empty schema': {'form': '', 'text': ''},
    'no schema': {'name': None},
    'lines that end with CR LF': {'text': TEXT.replace('\n', '\r\n')},
    'comments and another order of dependencies': {'text': '# a comment\n' + SEPARATOR.join(
        [TEXT.split(SEPARATOR)[0], *TEXT.split(SEPARATOR)[:0:-1]])},
    'no profile': {'profile': ''},
    'a header with a sequence number': {'text': SEQUENCE},
    'the name in C++': {'name': 'sensor_msgs::msg::JointState'},
    'the name in DDS': {'name': 'sensor_msgs::msg::dds_::JointState_'},
    'a schema in IDL': {'form': 'ros2idl', 'text': 'module sensor_msgs {};'},
    'an encoding in capitals': {'encoding': 'CDR'}, 'an empty encoding': {'encoding': ''},
    'an unknown profile': {'profile': 'mine'},
}


@pytest.mark.parametrize('how', READABLE)
def test_what_can_be_read_is_judged_and_replayed(tmp_path, made, how):
    messages = arm_messages(made)
    if 'sequence' in how:
        messages = with_sequence(messages)
    path = write(tmp_path / 'other.mcap', messages, **READABLE[how])
    result = validate(load_run(path, arm='ur5e'))
    assert result.verdict == 'pass' and result.about['states'] == 700
    played = load_playback(path)
    assert played.types == {'/joint_states': JOINT_STATE} and len(played.time) == 700
    first = decode(JOINT_STATE, played.data(0))
    assert np.array_equal(first['position'], made.q[0])
    assert played.time[-1] * 1e-9 == pytest.approx(1.398)


#: Definitions of other writers -> what is left of a JointState in them.
OTHER_FIELDS = {
    'no effort': TEXT.replace('float64[] effort\n', ''),
    'no velocity, no effort': TEXT.replace('float64[] effort\n', '').replace(
        'float64[] velocity\n', ''),
    'single precision': TEXT.replace('float64[]', 'float32[]'),
    'bounded names and numbers': TEXT.replace('string[] name', 'string<=30[<=9] name').replace(
        'float64[] position', 'float64[<=9] position'),
    'more fields': TEXT.replace('float64[] effort\n', 'float64[] effort\nfloat32[] current\n'),
}


@pytest.mark.parametrize('how', OTHER_FIELDS)
def test_joint_states_of_other_fields_are_read_by_their_own_definition(tmp_path, made, how):
    text = OTHER_FIELDS[how]
    definitions = parse_schema(JOINT_STATE, text)
    messages = []
    for time, data in arm_messages(made):
        message = decode(JOINT_STATE, data) | {'current': np.ones(6)}
        fields = [field.name for field in definitions[JOINT_STATE]]
        messages.append((time, encode(
            JOINT_STATE, {name: message[name] for name in fields}, definitions)))
    run = load_run(write(tmp_path / 'other.mcap', messages, text=text), arm='ur5e')
    failed = [check.name for check in validate(run).checks if check.verdict == 'fail']
    assert failed == (['evidence'] if 'velocity' in how else []) and len(run.stamp) == 700
    np.testing.assert_allclose(run.states.q, made.q, atol=1e-6)
    assert np.isnan(run.states.effort).all() == ('effort' in how)
    assert any('differentiated' in each for each in run.remarks) == ('velocity' in how)


REFUSED = {
    'ROS 1 messages': ({'name': 'sensor_msgs/JointState', 'form': 'ros1msg', 'encoding': 'ros1'},
                       'ROS 1 recording; convert it'),
    'JSON': ({'name': 'foxglove.JointStates', 'form': 'jsonschema', 'text': '{}',
              'encoding': 'json'}, "encoded as 'json'"),
    'protobuf': ({'name': 'x.JointStates', 'form': 'protobuf', 'encoding': 'protobuf'},
                 "encoded as 'protobuf'"),
    'other fields': ({'text': 'string[] name\nfloat32[] position\n'},
                     'otherwise than in ROS 2: its field header is missing; record it'),
    'names that are numbers': ({'text': TEXT.replace('string[] name', 'int32[] name')},
                               r'its field name is int32\[\]'),
}


@pytest.mark.parametrize('how', REFUSED)
def test_what_cannot_be_read_is_named_in_one_line(tmp_path, made, how):
    options, reason = REFUSED[how]
    path = write(tmp_path / 'other.mcap', arm_messages(made)[:5], **options)
    for act in (lambda: load_run(path, arm='ur5e'), lambda: load_playback(path)):
        with pytest.raises(InputError, match=reason) as caught:
            act()
        assert '\n' not in str(caught.value) and 'other.mcap' in str(caught.value)


def test_a_topic_of_another_encoding_does_not_keep_the_rest_from_a_replay(tmp_path, made):
    path = tmp_path / 'mixed.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start()
        joints = writer.register_channel('/joint_states', 'cdr', writer.register_schema(
            JOINT_STATE, 'ros2msg', TEXT.encode()))
        note = writer.register_channel('/note', 'json', writer.register_schema(
            'note', 'jsonschema', b'{}'))
        writer.add_message(note, 1, b'{}', 1)
        for time, data in arm_messages(made):
            writer.add_message(joints, time, data, time)
        writer.finish()
    played = load_playback(path)
    assert list(played.types) == ['/joint_states']
    assert len(played.remarks) == 1 and '/note' in played.remarks[0]
    with pytest.raises(InputError, match="nothing on topic /note .*'json'"):
        load_playback(path, ['/note'])


def test_messages_without_a_type_are_known_by_their_content_on_any_topic(tmp_path, made):
    path = tmp_path / 'untyped.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel('/robot/feedback', 'cdr', 0)
        other = writer.register_channel('/robot/noise', 'cdr', 0)
        for time, data in arm_messages(made):
            writer.add_message(channel, time, data, time)
            writer.add_message(other, time, data[::-1], time)
        writer.finish()
    result = validate(load_run(path, arm='ur5e'))
    assert result.verdict == 'pass' and result.about['states'] == 700


CUT = {'cut': (lambda data: data[:len(data) // 2], 'unfinished'),
       'zeros': (lambda data: data[:200] + bytes(len(data) - 400) + data[-200:], 'other.mcap'),
       'empty': (None, 'no message on /joint_states')}


@pytest.mark.parametrize('how', CUT)
def test_a_file_without_a_whole_message_is_refused_with_what_is_wrong(tmp_path, made, how):
    spoil, reason = CUT[how]
    path = write(tmp_path / 'other.mcap', arm_messages(made) if spoil else [])
    if spoil:
        path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(InputError, match=reason) as caught:
        load_run(path, arm='ur5e')
    assert '\n' not in str(caught.value)
    with pytest.raises(InputError, match='no message to send'):
        load_playback(path)


def test_a_file_that_holds_only_a_header_is_refused_in_one_line(tmp_path, made):
    whole = write(tmp_path / 'whole.mcap', arm_messages(made)[:5]).read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(whole[:46])
    for act in (lambda path: load_run(path, arm='ur5e'), load_playback):
        with pytest.raises(InputError, match='cut.mcap') as caught:
            act(tmp_path / 'cut.mcap')
        assert '\n' not in str(caught.value)


def test_two_channels_of_one_topic_are_one_topic(tmp_path, made):
    path = tmp_path / 'merged.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start()
        channels = [writer.register_channel('/joint_states', 'cdr', writer.register_schema(
            JOINT_STATE, 'ros2msg', TEXT.encode()), {'part': str(i)}) for i in range(2)]
        for k, (time, data) in enumerate(arm_messages(made)):
            writer.add_message(channels[k % 2], time, data, time)
        writer.finish()
    assert validate(load_run(path, arm='ur5e')).verdict == 'pass'
    assert len(load_playback(path).time) == 700


@pytest.mark.parametrize('messages', [arm_messages, lambda made: sorted(
    arm_messages(made) + gripper_messages(made))])
@pytest.mark.parametrize('metadata', [True, False])
def test_a_sqlite3_bag_is_judged_and_replayed(tmp_path, made, messages, metadata):
    with RosbagsWriter(tmp_path / 'bag', version=8,
                       storage_plugin=StoragePlugin.SQLITE3) as writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE,
                                      typestore=get_typestore(Stores.ROS2_JAZZY))
        for time, data in messages(made):
            writer.write(topic, time, data)
    if not metadata:
        (tmp_path / 'bag' / 'metadata.yaml').unlink()
    assert validate(load_run(tmp_path / 'bag', arm='ur5e')).verdict == 'pass'
    assert len(load_playback(tmp_path / 'bag').time) == len(messages(made))


def test_stamps_of_zero_do_not_send_a_replay_at_once(tmp_path, made):
    path = write(tmp_path / 'zero.mcap', [
        (time, data[:4] + bytes(8) + data[12:]) for time, data in arm_messages(made)])
    assert load_playback(path).time[-1] * 1e-9 == pytest.approx(1.398)


def test_a_replay_leaves_out_what_no_subscriber_could_read_and_counts_it(tmp_path, made):
    messages = arm_messages(made)
    spoiled = {3: b'', 7: b'\0\1', 50: b'\xff' * 200}
    path = write(tmp_path / 'spoiled.mcap', [
        (time, spoiled.get(k, data)) for k, (time, data) in enumerate(messages)])
    played = load_playback(path)
    assert len(played.time) == 697
    assert played.remarks[0] == ('topic /joint_states: 3 of 700 messages are no CDR; they are '
                                 'left out')
    whole = [data for k, (_, data) in enumerate(messages) if k not in spoiled]
    assert [played.data(i) for i in range(697)] == whole


def test_a_replay_says_what_of_a_bag_is_missing(tmp_path, made):
    path = write(tmp_path / 'cut.mcap', arm_messages(made))
    path.write_bytes(path.read_bytes()[:-3000])
    played = load_playback(path)
    assert any('unfinished' in remark for remark in played.remarks)
