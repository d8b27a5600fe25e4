"""Bags of other writers, in every form that rosbag2 gives them, read into the same arrays."""

import sys

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

from ur5_ros.bag.mcap.message_index import CompiledMessageIndex, index_messages
from ur5_ros.bag.reader import open_bag
from ur5_ros.cdr.fixed_messages import (
    FixedJointState,
    FixedPose,
    FixedTrajectoryPoint,
    encode,
    encode_clock,
)
from ur5_ros.cdr.recorded_types import schema_text
from ur5_ros.errors import BagError, InputError
from ur5_ros.signals import JOINT_NAMES

STORE = get_typestore(Stores.ROS2_JAZZY)
NUMBER = 300
STAMP = np.arange(1, NUMBER + 1) * 2_000_000
POSITION, VELOCITY, EFFORT = np.random.default_rng(3).normal(size=(3, NUMBER, 6))
JOINT_STATE = 'sensor_msgs/msg/JointState'


def states(names=JOINT_NAMES):
    """Return CDR messages of the arrays above, their columns in the order of ``names``."""
    codec = FixedJointState(names)
    order = [JOINT_NAMES.index(name) for name in names]
    return [codec.encode(int(STAMP[k]), POSITION[k, order], VELOCITY[k, order], EFFORT[k, order])
            for k in range(NUMBER)]


def big_endian():
    """Return the same messages in the other byte order."""
    time, header, state = (STORE.types[name] for name in (
        'builtin_interfaces/msg/Time', 'std_msgs/msg/Header', JOINT_STATE))
    return [bytes(STORE.serialize_cdr(state(
        header(time(*divmod(int(STAMP[k]), 10**9)), ''), list(JOINT_NAMES),
        POSITION[k], VELOCITY[k], EFFORT[k]), JOINT_STATE, little_endian=False))
        for k in range(NUMBER)]


def write_mcap(path, messages, schema=None, encoding='cdr', **options):
    """Write messages with the mcap package, as rosbag2's plugin lays them out."""
    with open(path, 'wb') as file:
        writer = Writer(file, **options)
        writer.start(profile='ros2', library='libmcap 1.3.0')
        schema_id = writer.register_schema(
            JOINT_STATE, 'ros2msg', (schema or schema_text(JOINT_STATE)).encode())
        channel = writer.register_channel('/joint_states', encoding, schema_id)
        for k, data in enumerate(messages):
            writer.add_message(channel, int(STAMP[k]) + 5, data, int(STAMP[k]) + 3)
        writer.finish()
    return path


def assert_right(columns):
    """Compare with the arrays above."""
    assert columns.names == JOINT_NAMES and columns.skipped == 0
    assert np.array_equal(columns.stamp, STAMP)
    assert np.array_equal(columns.position, POSITION)
    assert np.array_equal(columns.velocity, VELOCITY)
    assert np.array_equal(columns.effort, EFFORT)


@pytest.mark.fault(79)
@pytest.mark.parametrize('options', [
    {'compression': CompressionType.NONE}, {'compression': CompressionType.LZ4},
    {'compression': CompressionType.ZSTD}, {'use_chunking': False}, {'chunk_size': 1000},
    {'enable_crcs': False}, {'use_summary_offsets': False}, {'use_statistics': False},
    {'repeat_channels': False, 'repeat_schemas': False}, {'enable_data_crcs': True}], ids=str)
def test_every_way_to_write_an_mcap_file_gives_the_same_arrays(tmp_path, options):
    bag = open_bag(write_mcap(tmp_path / 'other.mcap', states(), **options))
    columns = bag.joint_states('/joint_states')
    assert_right(columns)
    assert np.array_equal(columns.log_time, STAMP + 5)
    assert np.array_equal(columns.publish_time, STAMP + 3)
    assert bag.check() == []


@pytest.mark.fault(79)
@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize('version', [8, 9])
def test_folders_as_rosbag2_writes_them_are_read(tmp_path, storage, version):
    qos = Qos(QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.VOLATILE,
              QosTime(0, 0), QosTime(0, 0), QosLiveliness.AUTOMATIC, QosTime(0, 0), False)
    with RosbagsWriter(tmp_path / 'bag', version=version, storage_plugin=storage) as writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE,
                                      offered_qos_profiles=[qos])
        for k, data in enumerate(states()):
            writer.write(topic, int(STAMP[k]), data)
    bag = open_bag(tmp_path / 'bag')
    assert_right(bag.joint_states('/joint_states'))
    assert bag.check() == [] and bag.counts() == {'/joint_states': NUMBER}


@pytest.mark.fault(79)
@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize(('mode', 'way_out'), [
    (CompressionMode.FILE, 'unzstd'), (CompressionMode.MESSAGE, 'ros2 bag convert')])
def test_compression_around_the_storage_is_refused_with_the_way_out(
        tmp_path, storage, mode, way_out):
    """As `ros2 bag record --compression-mode` writes it; bags in chunks of zstd are read."""
    folder = tmp_path / 'bag'
    writer = RosbagsWriter(folder, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
        for k, data in enumerate(states()):
            writer.write(topic, int(STAMP[k]), data)
    with pytest.raises(InputError, match=way_out) as refused:
        open_bag(folder)
    assert '\n' not in str(refused.value)
    if mode == CompressionMode.FILE:
        for file in folder.glob('*.zstd'):  # as unzstd does
            file.with_suffix('').write_bytes(
                zstandard.ZstdDecompressor().decompressobj().decompress(file.read_bytes()))
        bag = open_bag(folder)
        assert_right(bag.joint_states('/joint_states'))
        assert bag.check() == []
        for file in (*folder.glob('*.mcap'), *folder.glob('*.db3'), folder / 'metadata.yaml'):
            file.unlink()
        with pytest.raises(InputError, match=way_out):
            open_bag(folder)


@pytest.mark.fault(79)
@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_split_recording_is_one_bag(tmp_path, storage):
    """`ros2 bag record --max-bag-duration` names its files by number: 10 comes after 9."""
    folder, parts = tmp_path / 'bag', 12
    folder.mkdir()
    edges = np.linspace(0, NUMBER, parts + 1).astype(int)
    for part in range(parts):
        name = f'bag_{part}'
        with RosbagsWriter(tmp_path / name, version=9, storage_plugin=storage) as writer:
            topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
            for k in range(edges[part], edges[part + 1]):
                writer.write(topic, int(STAMP[k]), states()[k])
        [file] = [each for each in (tmp_path / name).iterdir() if each.suffix != '.yaml']
        file.rename(folder / file.name)
    assert len(list(folder.iterdir())) == parts
    bag = open_bag(folder)
    assert_right(bag.joint_states('/joint_states'))
    assert bag.counts() == {'/joint_states': NUMBER}


def sqlite3_bag(folder):
    with RosbagsWriter(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
        for k, data in enumerate(states()):
            writer.write(topic, int(STAMP[k]), data)
    return next(folder.glob('*.db3'))


def test_sqlite3_needs_no_metadata_and_no_package_and_one_file_is_enough(
        tmp_path, monkeypatch):
    file = sqlite3_bag(tmp_path / 'bag')
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    monkeypatch.setitem(sys.modules, 'rosbags.rosbag2', None)
    before = file.read_bytes()
    for path in (tmp_path / 'bag', file):
        bag = open_bag(path)
        assert_right(bag.joint_states('/joint_states'))
        assert bag.check() == [] and bag.counts() == {'/joint_states': NUMBER}
    assert file.read_bytes() == before and [each.name for each in file.parent.iterdir()] == [
        file.name]


@pytest.mark.parametrize('identifier', ['', 'mcap', 'sqlite3'])
def test_the_files_decide_what_the_storage_is_not_the_identifier(tmp_path, identifier):
    sqlite3_bag(tmp_path / 'bag')
    metadata = tmp_path / 'bag' / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace(
        'storage_identifier: sqlite3', f"storage_identifier: '{identifier}'"))
    bag = open_bag(tmp_path / 'bag')
    assert_right(bag.joint_states('/joint_states'))
    assert bag.check() == []


@pytest.mark.fault(79)
@pytest.mark.parametrize('size', [0.1, 0.5, 0.9])
def test_a_cut_sqlite3_bag_is_read_as_far_as_it_goes_or_refused_in_one_line(tmp_path, size):
    file = sqlite3_bag(tmp_path / 'bag')
    data = file.read_bytes()
    file.write_bytes(data[:int(size * len(data))])
    try:
        bag = open_bag(file)
    except BagError as problem:
        assert '\n' not in str(problem) and file.name in str(problem)
        return
    columns = bag.joint_states('/joint_states')
    assert len(columns.stamp) < NUMBER and bag.problems
    assert np.array_equal(columns.position, POSITION[:len(columns.stamp)])


@pytest.mark.fault(73)
def test_big_endian_messages_are_read(tmp_path):
    assert_right(open_bag(write_mcap(tmp_path / 'a.mcap', big_endian())).joint_states(
        '/joint_states'))


def test_columns_follow_the_names_whatever_order_a_message_has(tmp_path):
    forward, backward, shuffled = states(), states(JOINT_NAMES[::-1]), states(
        [JOINT_NAMES[at] for at in (2, 1, 0, 3, 4, 5)])
    mixed = [(forward, backward, shuffled, big_endian())[k % 4][k] for k in range(NUMBER)]
    bag = open_bag(write_mcap(tmp_path / 'a.mcap', mixed))
    assert_right(bag.joint_states('/joint_states', JOINT_NAMES))
    assert_right(bag.joint_states('/joint_states'))
    assert bag.joint_states('/joint_states', JOINT_NAMES[:1]).position.shape == (NUMBER, 1)


def test_a_gripper_between_the_joints_is_left_out_and_messages_without_the_arm_are_skipped(
        tmp_path):
    names = (JOINT_NAMES[0], 'finger', *JOINT_NAMES[1:])
    with_finger = FixedJointState(names)
    alone = FixedJointState(['finger']).encode(5, [1.0], [1.0], [1.0])
    messages = []
    for k in range(0, NUMBER, 2):
        values = [np.insert(each[k], 1, 9.9) for each in (POSITION, VELOCITY, EFFORT)]
        messages += [with_finger.encode(int(STAMP[k]), *values), alone]
    columns = open_bag(write_mcap(tmp_path / 'a.mcap', messages)).joint_states(
        '/joint_states', JOINT_NAMES)
    assert np.array_equal(columns.position, POSITION[::2]) and columns.skipped == NUMBER / 2


def test_a_field_that_is_left_empty_is_nan(tmp_path):
    codec = FixedJointState(JOINT_NAMES, fields=('effort',))
    messages = [codec.encode(int(STAMP[k]), effort=EFFORT[k]) for k in range(NUMBER)]
    columns = open_bag(write_mcap(tmp_path / 'a.mcap', messages)).joint_states('/joint_states')
    assert np.array_equal(columns.effort, EFFORT) and np.isnan(columns.position).all()


@pytest.mark.fault(73)
def test_messages_without_names_or_cut_off_are_skipped_and_counted(tmp_path):
    nameless = encode(JOINT_STATE, {'position': np.zeros(6)})
    doubled = FixedJointState([JOINT_NAMES[0]] * 6).encode(1, *[np.zeros(6)] * 3)
    unequal = encode(JOINT_STATE, {'name': JOINT_NAMES, 'position': np.zeros(5)})
    good = states()
    bag = open_bag(write_mcap(tmp_path / 'a.mcap', [
        nameless, good[0], doubled, good[1][:100], unequal, good[2], b'', good[3]]))
    columns = bag.joint_states('/joint_states')
    assert np.array_equal(columns.position, POSITION[[0, 2, 3]]) and columns.skipped == 5
    assert any('2 messages could not be read' in problem for problem in bag.problems)


def test_more_layouts_than_are_remembered_are_still_read(tmp_path):
    order = np.random.default_rng(0)
    messages = []
    for k in range(NUMBER):
        names = [JOINT_NAMES[at] for at in order.permutation(6)]
        columns = [JOINT_NAMES.index(name) for name in names]
        messages.append(FixedJointState(names, frame_id=f'frame {k % 40}').encode(
            int(STAMP[k]), POSITION[k, columns], VELOCITY[k, columns], EFFORT[k, columns]))
    assert_right(open_bag(write_mcap(tmp_path / 'a.mcap', messages)).joint_states(
        '/joint_states', JOINT_NAMES))


def test_several_topics_come_in_one_pass(record, tmp_path):
    written = record(tmp_path / 'bag')
    loaded = open_bag(written.folder).load({'/joint_states': None, '/clock': None})
    assert np.array_equal(loaded['/joint_states'].position, written.position)
    clock = loaded['/clock']
    assert clock.log_time.tolist() == written.stamp.tolist()
    assert bytes(clock.data[clock.offsets[7]:clock.offsets[8]]) == encode_clock(8_000_000)


def test_references_and_poses_become_columns(tmp_path):
    from ur5_ros.bag.writer import BagWriter
    point, pose = FixedTrajectoryPoint(JOINT_NAMES), FixedPose('base')
    parts = np.random.default_rng(4).normal(size=(50, 4, 6))
    with BagWriter(tmp_path / 'bag', {}) as writer:
        reference = writer.topic('/reference', 'trajectory_msgs/msg/JointTrajectory')
        tool = writer.topic('/tool_pose', 'geometry_msgs/msg/PoseStamped')
        for k in range(50):
            writer.write(reference, k, point.encode(k, *parts[k]))
            writer.write(tool, k, pose.encode(k, parts[k, 0, :3], parts[k, 1, :4]))
        writer.write(reference, 99, encode('trajectory_msgs/msg/JointTrajectory', {
            'joint_names': JOINT_NAMES, 'points': [{}, {}]}))
    loaded = open_bag(tmp_path / 'bag').load({'/reference': None, '/tool_pose': None})
    for at, name in enumerate(point.FIELDS):
        assert np.array_equal(loaded['/reference'].fields[name], parts[:, at])
    assert loaded['/reference'].skipped == 1
    assert np.array_equal(loaded['/tool_pose'].pose[:, :3], parts[:, 0, :3])
    assert np.array_equal(loaded['/tool_pose'].pose[:, 3:], parts[:, 1, :4])


def test_messages_come_one_by_one_as_dicts(recorded):
    events = list(open_bag(recorded.folder).messages('/ur5_sim/events'))
    assert [time for time, _ in events] == [1_000_000, 51_000_000, 101_000_000, 151_000_000]
    assert events[2][1]['status'][0]['message'] == 'period 100'


def test_the_compiled_walk_finds_what_the_walk_in_python_finds(recorded):
    compiled = CompiledMessageIndex()
    source = open_bag(recorded.folder).sources[0]
    for batch in source.batches():
        for size in (len(batch.buffer), len(batch.buffer) - 1, 0, 31, 40):
            one, other = index_messages(batch.buffer[:size]), compiled(batch.buffer[:size])
            assert (one is None) == (other is None)
            if one is not None:
                assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize('window', [20, 1000, 50_000])
def test_a_file_that_is_read_piece_by_piece_gives_the_same(recorded, monkeypatch, window):
    monkeypatch.setattr('ur5_ros.bag.mcap.record_scan.READ_SIZE', window)
    bag = open_bag(recorded.folder)
    assert np.array_equal(bag.joint_states('/joint_states').position, recorded.position)
    assert bag.check() == []


def test_a_large_bag_is_walked_by_compiled_code_to_the_same_end(record, tmp_path, monkeypatch):
    written = record(tmp_path / 'bag', periods=3000)
    monkeypatch.setattr('ur5_ros.bag.reader.COMPILE_ABOVE', 0)
    bag = open_bag(written.folder)
    assert np.array_equal(bag.joint_states('/joint_states').position, written.position)
    assert bag.check() == []


@pytest.mark.fault(74)
def test_a_schema_that_is_not_the_types_is_named(tmp_path):
    swapped = schema_text(JOINT_STATE).replace('position', 'speed')
    bag = open_bag(write_mcap(tmp_path / 'a.mcap', states(), schema=swapped))
    with pytest.raises(BagError, match='defined otherwise'):
        bag.joint_states('/joint_states')


def test_another_message_encoding_is_named(tmp_path):
    bag = open_bag(write_mcap(tmp_path / 'a.mcap', states(), encoding='json'))
    with pytest.raises(BagError, match='only cdr'):
        bag.joint_states('/joint_states')


def test_a_topic_that_is_not_there_is_refused_with_those_that_are(recorded):
    with pytest.raises(InputError, match='there are: /clock, /joint_states'):
        open_bag(recorded.folder).joint_states('/joint_command')


def test_a_type_of_another_package_is_read_by_its_own_schema(tmp_path):
    with open(tmp_path / 'a.mcap', 'wb') as file:
        writer = Writer(file)
        writer.start(profile='ros2')
        schema = writer.register_schema('p/msg/Pair', 'ros2msg', b'int32 a\nstring[<=2] b\n')
        channel = writer.register_channel('/pair', 'cdr', schema)
        writer.add_message(channel, 1, b'\0\1\0\0\7\0\0\0\1\0\0\0\2\0\0\0x\0', 1)
        writer.finish()
    assert list(open_bag(tmp_path / 'a.mcap').messages('/pair')) == [(1, {'a': 7, 'b': ['x']})]
