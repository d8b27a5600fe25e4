"""Bags whose metadata.yaml or file names are damaged: the messages decide what is lost."""

import os
import re
import shutil

import pytest
import yaml
from foreign_recordings import arm_messages, motion, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.errors import InputError


@pytest.fixture(scope='module')
def whole(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp('contents') / 'bag',
                     {'/joint_states': arm_messages(motion())})


@pytest.fixture
def bag(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / 'bag')


def rewrite(change):
    def damage(folder):
        path = folder / 'metadata.yaml'
        path.write_text(change(path.read_text()))
    return damage


def rename(folder):
    next(folder.glob('*.mcap')).rename(folder / 'monday.mcap')


HARMLESS = {
    'empty': (rewrite(lambda text: ''), 'no rosbag2_bagfile_information'),
    'no YAML': (rewrite(lambda text: 'a:\n\tb: [9'), 'not valid YAML'),
    'cut off': (rewrite(lambda text: text[:len(text) // 3]), 'metadata.yaml'),
    'a newer version': (rewrite(lambda text: re.sub(
        r'version: \d+', 'version: 99', text, count=1)), 'version 99; versions up to'),
    'fewer messages than there are': (rewrite(lambda text: re.sub(
        'message_count: 700', 'message_count: 9', text)), 'says 9 messages; counted: 700'),
    'no messages': (rewrite(lambda text: re.sub(
        'message_count: 700', 'message_count: 0', text)), 'says 0 messages; counted: 700'),
    'another type': (rewrite(lambda text: text.replace(
        'sensor_msgs/msg/JointState', 'std_msgs/msg/String')), 'is of another type'),
    'a file of another name': (rename, 'is missing, though metadata.yaml names it'),
}


@pytest.mark.parametrize('how', HARMLESS)
def test_a_damaged_metadata_yaml_takes_nothing_from_a_whole_recording(bag, how):
    damage, reason = HARMLESS[how]
    damage(bag)
    result = validate(load_run(bag, arm='ur5e'))
    assert result.verdict == 'pass' and result.about['states'] == 700
    assert reason in '; '.join(result.about['remarks'])


def fewer(folder):
    path = folder / 'metadata.yaml'
    data = yaml.safe_load(path.read_text())
    data['rosbag2_bagfile_information']['message_count'] = 900
    path.write_text(yaml.safe_dump(data))


def without_its_second_part(folder):
    path = folder / 'metadata.yaml'
    data = yaml.safe_load(path.read_text())
    information = data['rosbag2_bagfile_information']
    information['relative_file_paths'].append('bag_1.mcap')
    information['message_count'] = 1400
    path.write_text(yaml.safe_dump(data))


@pytest.mark.parametrize('damage', [fewer, without_its_second_part])
def test_messages_that_were_written_and_are_not_there_fail(bag, damage):
    damage(bag)
    result = validate(load_run(bag, arm='ur5e'))
    assert result.verdict == 'fail' and result.check('recording').verdict == 'fail'


def test_an_mcap_file_is_read_under_the_name_of_the_other_storage(bag):
    file = next(bag.glob('*.mcap'))
    file.rename(bag / 'bag_0.db3')
    (bag / 'metadata.yaml').unlink()
    for path in (bag, bag / 'bag_0.db3'):
        assert validate(load_run(path, arm='ur5e')).verdict == 'pass'


@pytest.mark.parametrize('name, content, reason', [
    ('a.db3', b'', 'it holds nothing'), ('a.mcap', b'', 'holds nothing'),
    ('a.db3', b'text\n' * 99, 'not an sqlite3 file; give the bag'),
    ('a.mcap', b'text\n' * 99, 'not an MCAP file; give the bag')])
def test_a_file_that_is_no_recording_is_named_with_the_way_out(tmp_path, name, content, reason):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=reason) as caught:
        load_run(tmp_path / name, arm='ur5e')
    assert '\n' not in str(caught.value) and name in str(caught.value)


def test_messages_in_another_form_of_cdr_are_named_with_it(tmp_path):
    messages = [(time, b'\0\x0a\0\0' + data[4:]) for time, data in arm_messages(motion(n=5))]
    folder = write_bag(tmp_path / 'bag', {'/joint_states': messages})
    with pytest.raises(InputError, match='encapsulation 0x00 0x0a; only plain CDR') as caught:
        load_run(folder, arm='ur5e')
    assert '/joint_states' in str(caught.value)


@pytest.mark.parametrize('metadata', [True, False])
@pytest.mark.parametrize('name', ['._bag_0.mcap', '._bag_0.db3', '.hidden.mcap'])
def test_hidden_files_that_other_systems_leave_are_no_part_of_a_bag(bag, name, metadata):
    (bag / name).write_bytes(b'\0\5\x16\7\0\2\0\0Mac OS X')
    if not metadata:
        (bag / 'metadata.yaml').unlink()
    result = validate(load_run(bag, arm='ur5e'))
    assert result.verdict == 'pass' and result.check('recording').verdict == 'pass'


def test_what_is_neither_file_nor_folder_is_named(tmp_path):
    os.mkfifo(tmp_path / 'pipe.mcap')
    with pytest.raises(InputError, match='pipe.mcap: neither a file nor a folder; give the bag'):
        load_run(tmp_path / 'pipe.mcap', arm='ur5e')
