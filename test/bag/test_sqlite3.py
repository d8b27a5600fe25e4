"""sqlite3 bags as crashes, compression and other hands leave them: read, or named in one line."""

import shutil
import sqlite3

import pytest
import zstandard
from foreign_recordings import JOINT_STATE, arm_messages, motion

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.playback import load_playback
from ur5_ros.bag.reader import open_bag
from ur5_ros.errors import InputError


@pytest.fixture(scope='module')
def messages():
    return arm_messages(motion())


def database(path, mode='DELETE'):
    """Return a connection to a new file with the tables of rosbag2."""
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute(f'PRAGMA journal_mode={mode}')
    connection.execute('CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, '
                       'serialization_format TEXT, offered_qos_profiles TEXT)')
    connection.execute('CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, '
                       'timestamp INTEGER, data BLOB)')
    connection.execute('INSERT INTO topics VALUES(1, "/joint_states", ?, "cdr", "")',
                       (JOINT_STATE,))
    return connection


def insert(connection, messages):
    connection.execute('BEGIN')
    connection.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)',
                           messages)
    connection.execute('COMMIT')


def test_messages_that_are_only_in_the_write_ahead_log_are_read(tmp_path, messages):
    connection = database(tmp_path / 'open.db3', 'WAL')
    connection.execute('PRAGMA wal_autocheckpoint=0')
    insert(connection, messages)
    crashed = tmp_path / 'crashed'
    crashed.mkdir()
    for name in ('open.db3', 'open.db3-wal'):
        shutil.copy(tmp_path / name, crashed / name)
    connection.close()
    before = {file.name: file.read_bytes() for file in crashed.iterdir()}
    result = validate(load_run(crashed, arm='ur5e'))
    assert result.verdict == 'pass' and result.about['states'] == len(messages)
    assert len(load_playback(crashed / 'open.db3').time) == len(messages)
    # nothing is created or changed beside the recording
    assert {file.name: file.read_bytes() for file in crashed.iterdir()} == before


def test_a_transaction_that_was_not_ended_is_taken_back(tmp_path, messages):
    connection = database(tmp_path / 'open.db3')
    insert(connection, messages[:600])
    connection.execute('PRAGMA cache_size=2')
    connection.execute('BEGIN')
    connection.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)',
                           messages[600:])
    crashed = tmp_path / 'crashed'
    crashed.mkdir()
    for name in ('open.db3', 'open.db3-journal'):
        shutil.copy(tmp_path / name, crashed / name)
    connection.close()
    assert (crashed / 'open.db3-journal').stat().st_size
    bag = open_bag(crashed)
    assert bag.check() == [] and bag.counts() == {'/joint_states': 600}


def test_a_bag_in_parts_without_metadata_is_one_bag(tmp_path, messages):
    for i, part in enumerate((messages[:300], messages[300:])):
        connection = database(tmp_path / f'bag_{i}.db3')
        insert(connection, part)
        connection.close()
    result = validate(load_run(tmp_path, arm='ur5e'))
    assert result.verdict == 'pass' and result.about['states'] == len(messages)


METADATA = """\
rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  relative_file_paths: [{name}]
  duration: {{nanoseconds: 1398000000}}
  starting_time: {{nanoseconds_since_epoch: 1780000000000000000}}
  message_count: 700
  topics_with_message_count:
    - topic_metadata: {{name: /joint_states, type: sensor_msgs/msg/JointState,
        serialization_format: cdr, offered_qos_profiles: ""}}
      message_count: 700
  compression_format: zstd
  compression_mode: {mode}
"""


def compressed_file(folder, messages, metadata):
    """Write a bag whose file is compressed as a whole."""
    connection = database(folder / 'bag_0.db3')
    insert(connection, messages)
    connection.close()
    data = (folder / 'bag_0.db3').read_bytes()
    (folder / 'bag_0.db3').unlink()
    (folder / 'bag_0.db3.zstd').write_bytes(zstandard.compress(data))
    if metadata:
        (folder / 'metadata.yaml').write_text(METADATA.format(name='bag_0.db3.zstd', mode='FILE'))


@pytest.mark.parametrize('metadata', [True, False])
def test_a_compressed_file_is_refused_with_what_decompresses_it(tmp_path, messages, metadata):
    compressed_file(tmp_path, messages, metadata)
    for path in (tmp_path, tmp_path / 'bag_0.db3.zstd'):
        for act in (lambda path: load_run(path, arm='ur5e'), load_playback):
            with pytest.raises(InputError, match='compressed.*zstd.* bag_0.db3.zstd') as caught:
                act(path)
            assert '\n' not in str(caught.value)


def test_a_file_that_was_decompressed_by_hand_is_read(tmp_path, messages):
    compressed_file(tmp_path, messages, True)
    packed = tmp_path / 'bag_0.db3.zstd'
    (tmp_path / 'bag_0.db3').write_bytes(zstandard.decompress(packed.read_bytes()))
    run = load_run(tmp_path, arm='ur5e')
    assert len(run.stamp) == len(messages)


@pytest.mark.parametrize('metadata', [True, False])
def test_compressed_messages_are_refused_with_the_way_out(tmp_path, messages, metadata):
    connection = database(tmp_path / 'bag_0.db3')
    insert(connection, [(time, zstandard.compress(data)) for time, data in messages])
    connection.close()
    if metadata:
        (tmp_path / 'metadata.yaml').write_text(METADATA.format(name='bag_0.db3', mode='MESSAGE'))
    with pytest.raises(InputError, match='compressed.*ros2 bag convert') as caught:
        load_run(tmp_path, arm='ur5e')
    assert '\n' not in str(caught.value)


def test_a_folder_with_a_bag_of_ros_1_is_refused_by_name(tmp_path):
    (tmp_path / 'old.bag').write_bytes(b'#ROSBAG V2.0\n')
    with pytest.raises(InputError, match='old.bag: a bag of ROS 1; convert it with'):
        load_run(tmp_path, arm='ur5e')


@pytest.mark.parametrize('name', ['log.csv', 'log.csv.gz'])
def test_a_robots_log_is_no_bag_and_the_way_to_one_is_named(tmp_path, name):
    data = b'\x1f\x8b' if name.endswith('gz') else b'timestamp,actual_q_0\n'
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=f'ur5 import {name} --out RUN'):
        load_run(tmp_path / name)
