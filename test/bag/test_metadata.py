"""metadata.yaml missing, wrong or hostile: rebuilt, cross-checked or refused."""

import os
import re

import pytest
import yaml

from ur5_ros.bag.reader import open_bag
from ur5_ros.errors import BagError, InputError

pytestmark = pytest.mark.fault(75)


@pytest.fixture
def change(recorded):
    """Return a function that changes what metadata.yaml says and returns the bag's folder."""
    path = recorded.folder / 'metadata.yaml'

    def apply(edit):
        data = yaml.safe_load(path.read_text())
        edit(data['rosbag2_bagfile_information'])
        path.write_text(yaml.safe_dump(data))
        return recorded.folder
    return apply


def problems_of(folder):
    """Return what is wrong with a bag whose messages are all there."""
    bag = open_bag(folder)
    assert len(bag.joint_states('/joint_states').stamp) == 200
    assert all('\n' not in problem for problem in bag.problems)
    return '; '.join(bag.problems)


def test_a_description_that_rosbag2_has_written_again_is_the_same(recorded):
    """`ros2 bag reindex` keeps custom_data, in another order and without quotes."""
    path = recorded.folder / 'metadata.yaml'
    data = yaml.safe_load(path.read_text())
    custom = data['rosbag2_bagfile_information']['custom_data']
    assert custom and problems_of(recorded.folder) == ''
    data['rosbag2_bagfile_information']['custom_data'] = dict(sorted(custom.items()))
    text = yaml.safe_dump(data, sort_keys=False, width=10**6)
    unquoted = re.sub(r"^(    \w+: )'(\w+)'$", r'\1\2', text, flags=re.MULTILINE)
    assert unquoted != text
    path.write_text(unquoted)
    assert problems_of(recorded.folder) == ''


@pytest.mark.parametrize('name', ['../bag/bag_0.mcap', '/etc/passwd', 'sub/bag_0.mcap', '..', '',
                                  'a\\b.mcap', 'bag_0.mcap\0'])
def test_a_path_that_leaves_the_folder_is_named_and_not_followed(change, name):
    folder = change(lambda info: info.update(relative_file_paths=[name]))
    assert 'metadata.yaml' in problems_of(folder)
    (folder / 'bag_0.mcap').unlink()
    with pytest.raises(BagError, match='only files of the folder itself|not valid YAML'):
        open_bag(folder)


def test_a_file_that_is_named_twice_is_read_once(change):
    folder = change(lambda info: info.update(relative_file_paths=['bag_0.mcap'] * 2))
    assert 'names a file twice' in problems_of(folder)


def test_a_file_that_is_missing_is_named(change):
    folder = change(lambda info: info.update(relative_file_paths=['bag_0.mcap', 'bag_1.mcap']))
    assert 'bag_1.mcap: is missing' in problems_of(folder)


def test_a_link_out_of_the_folder_is_not_named_by_metadata(change, tmp_path):
    folder = change(lambda info: None)
    (folder / 'bag_1.mcap').symlink_to('/etc/passwd')
    assert 'bag_1.mcap' in problems_of(folder)


@pytest.mark.parametrize('edit, word', [
    (lambda info: info.update(message_count=9999), 'says 9999 messages'),
    (lambda info: info['topics_with_message_count'][0].update(message_count=7),
     'says 7 messages on /joint_states'),
    (lambda info: info['topics_with_message_count'].pop(0), 'says 0 messages on /joint_states'),
    (lambda info: info['topics_with_message_count'][0]['topic_metadata'].update(
        type='std_msgs/msg/String'), 'of another type'),
    (lambda info: info.update(version=99), 'version 99'),
    (lambda info: info.update(version='nine'), 'version'),
    (lambda info: info.pop('relative_file_paths'), 'relative_file_paths'),
    (lambda info: info['custom_data'].update(run='another'), 'custom_data differ'),
    (lambda info: info['custom_data'].update(run=[1]), 'custom_data'),
], ids=range(9))
def test_a_wrong_entry_is_named_and_the_messages_are_read(change, edit, word):
    assert word in problems_of(change(edit))


@pytest.mark.parametrize('text', [
    '', '42', '[1, 2]', 'rosbag2_bagfile_information: 5', '\0', '\xff\xfe', '{' * 10_000,
    'a: !!python/object/apply:os.system [touch /tmp/owned]',
    'a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n', 'x: ' + 'y' * 2_000_000,
    'rosbag2_bagfile_information:\n  version: 9\n  version: 9\n'],
    ids=['empty', 'number', 'list', 'short', 'zero', 'bytes', 'deep', 'python', 'aliases', 'long',
         'doubled'])
def test_hostile_yaml_is_named_and_the_messages_are_read(recorded, text):
    (recorded.folder / 'metadata.yaml').write_text(text, encoding='latin-1')
    assert 'metadata.yaml' in problems_of(recorded.folder)


def test_metadata_yaml_that_is_a_folder_is_named(recorded):
    (recorded.folder / 'metadata.yaml').unlink()
    (recorded.folder / 'metadata.yaml').mkdir()
    assert 'metadata.yaml' in problems_of(recorded.folder)


def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(recorded):
    os.mkfifo(recorded.folder / 'bag_1.mcap')
    assert 'bag_1.mcap: no file' in problems_of(recorded.folder)
    (recorded.folder / 'metadata.yaml').unlink()
    os.mkfifo(recorded.folder / 'metadata.yaml')
    assert 'no file metadata.yaml' in problems_of(recorded.folder)


def test_a_missing_one_is_named_with_the_way_out(recorded):
    (recorded.folder / 'metadata.yaml').unlink()
    assert 'ur5 recover' in problems_of(recorded.folder)


def test_a_bag_without_any_file_is_refused(recorded):
    (recorded.folder / 'bag_0.mcap').unlink()
    with pytest.raises(BagError, match='no .mcap file'):
        open_bag(recorded.folder)


def test_an_unknown_storage_is_refused(change):
    folder = change(lambda info: info.update(storage_identifier='my_plugin'))
    with pytest.raises(InputError, match='my_plugin'):
        open_bag(folder)


def test_an_sqlite3_bag_that_is_damaged_is_named(tmp_path):
    (tmp_path / 'metadata.yaml').write_text(yaml.safe_dump({'rosbag2_bagfile_information': {
        'version': 5, 'storage_identifier': 'sqlite3', 'relative_file_paths': ['a.db3']}}))
    (tmp_path / 'a.db3').write_bytes(b'noise' * 1000)
    with pytest.raises(BagError, match='not an sqlite3 file') as caught:
        open_bag(tmp_path)
    assert '\n' not in str(caught.value)
