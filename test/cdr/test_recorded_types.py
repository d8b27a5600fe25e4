"""Message definitions, schemas and type hashes against those of ROS 2 and rosbags."""

import json
import os
import sys
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ur5_ros.cdr.message_definition import MAX_TEXT, parse_definition, parse_schema
from ur5_ros.cdr.recorded_types import (
    DEFINITIONS,
    definition,
    dependencies,
    schema_text,
    type_hash,
)
from ur5_ros.errors import BagError, InputError

STORE = get_typestore(Stores.ROS2_JAZZY)


def installed(type_name: str, ending: str) -> list[Path]:
    """Return the file of an installed message package; none on a machine without ROS."""
    package, _, name = type_name.partition('/msg/')
    prefixes = [sys.prefix, *os.environ.get('AMENT_PREFIX_PATH', '').split(':')]
    files = [Path(prefix, 'share', package, 'msg', f'{name}.{ending}') for prefix in prefixes]
    return [file for file in files if file.is_file()]


@pytest.mark.parametrize('type_name', sorted(DEFINITIONS))
def test_type_hashes_equal_those_of_rosbags(type_name):
    assert type_hash(type_name) == STORE.hash_rihs01(type_name)


@pytest.mark.parametrize('type_name', sorted(DEFINITIONS))
def test_type_hashes_equal_those_of_the_installed_packages(type_name):
    for file in installed(type_name, 'json'):
        hashes = {entry['type_name']: entry['hash_string']
                  for entry in json.loads(file.read_text())['type_hashes']}
        assert type_hash(type_name) == hashes[type_name]


@pytest.mark.parametrize('type_name', sorted(DEFINITIONS))
def test_rosbags_reads_our_schema_as_the_type_of_ros(type_name):
    read = get_types_from_msg(schema_text(type_name), type_name)
    assert set(read) == {type_name, *dependencies(type_name)}
    for name, fields in read.items():
        assert fields[1] == STORE.fielddefs[name][1]


@pytest.mark.parametrize('type_name', sorted(DEFINITIONS))
def test_the_schema_that_rosbag2_writes_is_read_as_ours(type_name):
    theirs = STORE.generate_msgdef(type_name, ros_version=2)[0]
    read = parse_schema(type_name, theirs)
    for name in (type_name, *dependencies(type_name)):
        assert read[name] == definition(name)


@pytest.mark.parametrize('type_name', sorted(DEFINITIONS))
def test_the_installed_msg_file_is_read_as_ours(type_name):
    for file in installed(type_name, 'msg'):
        assert parse_definition(type_name, file.read_text()) == definition(type_name)


def test_all_forms_of_a_declaration_are_read():
    fields = parse_schema('p/msg/A', (
        'bool a\nfloat32[3] b # three\nint8[<=5] c\nuint64[] d [1, 2]\nstring<=7 e "x#y"\n'
        'int32 NUMBER=3\nstring TEXT = hash\nB g\nq/C[] h\nHeader i\nchar j 5\n'
        + '=' * 80 + '\nMSG: p/B\nbyte x\n' + '=' * 80 + '\nMSG: q/C\n'
        + '=' * 80 + '\nMSG: std_msgs/Header\nuint32 seq\n'))['p/msg/A']
    assert [(f.name, f.base, f.array, f.size, f.text_bound) for f in fields] == [
        ('a', 'bool', '', 0, 0), ('b', 'float32', 'fixed', 3, 0), ('c', 'int8', 'bounded', 5, 0),
        ('d', 'uint64', 'open', 0, 0), ('e', 'string', '', 0, 7), ('g', 'p/msg/B', '', 0, 0),
        ('h', 'q/msg/C', 'open', 0, 0), ('i', 'std_msgs/msg/Header', '', 0, 0),
        ('j', 'char', '', 0, 0)]


@pytest.mark.fault(74)
@pytest.mark.parametrize('text', [
    'float64', '??', 'int8[x] y', 'int8[<=] y', 'p/msg/A again', 'q/B missing',
    'int8 a\n' * 1000, ('=' * 80 + '\nMSG: q/B\n') * 200, '=' * 80 + '\nIDL: q/B\n',
    'x' * (MAX_TEXT + 1),
    'B b\n' + '=' * 80 + '\nMSG: p/B\nA a\n'])
def test_a_hostile_schema_is_named(text):
    with pytest.raises(BagError) as caught:
        parse_schema('p/msg/A', text)
    assert '\n' not in str(caught.value)


def test_an_unknown_type_is_refused():
    with pytest.raises(InputError, match='is not recorded'):
        schema_text('p/msg/A')
