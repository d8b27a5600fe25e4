"""Cut, flipped, swollen and lying bags: named within bounds, never believed, never a traceback."""

import os
import random
import subprocess
import sys
import textwrap
import zlib

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.records import Channel, Header, Schema

from ur5_ros.bag.mcap.records import FRAME, MAGIC, MESSAGE, Opcode, record_bytes
from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.rosbag2_folder import BagFolder, make_topic
from ur5_ros.cdr.fixed_messages import FixedJointState, encode_clock
from ur5_ros.cdr.recorded_types import schema_text
from ur5_ros.errors import BagError, InputError

JOINT_STATE = 'sensor_msgs/msg/JointState'


def write_small(folder, type_name, messages):
    """Write a finished bag of a few kilobytes: eight chunks of five messages."""
    bag = BagFolder(folder, 'small', {'run': 'r', 'parameters': '{"kp": [100.0]}'})
    bag.topics.append(make_topic(1, 1, '/topic', (type_name, schema_text(type_name).encode()),
                                 [qos_profile()], 'RIHS01_00'))
    for begin in range(0, 40, 5):
        bag.write([(1, k, k, messages(k)) for k in range(begin + 1, begin + 6)])
    bag.note('summary', {'periods': '40'})
    bag.finish()
    return folder


@pytest.fixture
def small(tmp_path):
    """Return a small bag of joint states."""
    codec, rng = FixedJointState(['a', 'b']), np.random.default_rng(5)
    return write_small(tmp_path / 'small', JOINT_STATE,
                       lambda k: codec.encode(k, *rng.normal(size=(3, 2))))


def contents(path):
    """Return all that a reader gets out of a bag, and what it says is wrong with it."""
    bag = open_bag(path)
    raw = {topic: bag.columns(topic) for topic in bag.topics}
    taken = ({topic: [column.tolist() for column in columns] for topic, columns in raw.items()},
             bag.topics, bag.description, bag.notes)
    for problem in bag.problems:
        assert '\n' not in problem
    return taken, bag.problems


@pytest.mark.fault(69)
def test_a_file_cut_at_any_byte_gives_its_whole_chunks_and_says_that_it_is_cut(
        tmp_path, times, record_property):
    small = write_small(tmp_path / 'small', 'rosgraph_msgs/msg/Clock', encode_clock)
    whole = (small / 'small_0.mcap').read_bytes()
    cut = tmp_path / 'cut.mcap'
    before = 0
    sizes = sorted({*range(0, len(whole), times(7, 1)), *range(len(whole) - 50, len(whole))})
    for size in sizes:
        cut.write_bytes(whole[:size])
        bag = open_bag(cut)
        stamps = bag.columns('/topic').log_time.tolist() if bag.topics else []
        assert stamps == list(range(1, len(stamps) + 1))
        assert len(stamps) >= before and not bag.complete
        before = len(stamps)
    assert before == 40
    record_property('bag cut off at so many different bytes', len(sizes))


def flips(data, number, seed):
    """Yield copies of bytes with one bit turned round."""
    chosen = random.Random(seed)
    for _ in range(number):
        at, bit = chosen.randrange(len(data)), chosen.randrange(8)
        changed = bytearray(data)
        changed[at] ^= 1 << bit
        yield at, bytes(changed)


@pytest.mark.fault(70)
@pytest.mark.parametrize('state, number', [('finished', 5000), ('unfinished', 2000)])
def test_a_flipped_bit_is_found_or_changes_nothing(small, tmp_path, state, number, times,
                                                   record_property):
    number = times(number // 10, number)
    data = (small / 'small_0.mcap').read_bytes()
    if state == 'unfinished':
        data = data[:data.rindex(FRAME.pack(Opcode.DATA_END, 4))]
    flipped = tmp_path / 'flipped.mcap'
    flipped.write_bytes(data)
    truth, expected = contents(flipped)
    silent = harmless = 0
    for at, changed in flips(data, number, 16):
        flipped.write_bytes(changed)
        try:
            taken, problems = contents(flipped)
        except InputError:
            continue
        if problems == expected:
            harmless += 1
            assert taken == truth, f'silent change by a flip in byte {at}'
            silent += state == 'finished'
    assert silent == 0, 'a finished file has a CRC over every byte'
    record_property('bags with a flipped bit', number)
    record_property('flipped bits that change nothing that is read', harmless)


@pytest.mark.fault(70, 75)
def test_a_flipped_bit_in_metadata_yaml_is_found_or_changes_nothing(small):
    truth, _ = contents(small)
    data = (small / 'metadata.yaml').read_bytes()
    for at, changed in flips(data, 400, 7):
        (small / 'metadata.yaml').write_bytes(changed)
        try:
            taken, problems = contents(small)
        except InputError:
            continue
        assert problems or taken == truth, f'silent change by a flip in byte {at}'


LIMITED = """
    import resource, sys
    import numpy, lz4.frame, zstandard
    from ur5_ros.bag.reader import open_bag
    from ur5_ros.errors import InputError
    used = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    resource.setrlimit(resource.RLIMIT_CPU, (int(used) + 3, int(used) + 4))
    try:
        bag = open_bag(sys.argv[1])
        bag.check()
        for topic in bag.topics:
            bag.columns(topic)
        print(*bag.problems, sep='\\n')
    except InputError as refusal:
        print(refusal)
    status = open('/proc/self/status').read()  # ru_maxrss would begin with the parent's
    print(int(status.partition('VmHWM:')[2].split()[0]) // 1024)
"""


def read_limited(path, record_property):
    """Read a hostile file in a process of its own, within 2 s and 300 MB; return its words."""
    result = subprocess.run([sys.executable, '-c', textwrap.dedent(LIMITED), str(path)],
                            capture_output=True, text=True, timeout=60,
                            env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'})
    assert result.returncode == 0, (result.returncode, result.stderr)
    *problems, memory = result.stdout.splitlines()
    assert problems and int(memory) < 300
    record_property('memory for reading a bag made to exhaust it [MB]', int(memory))
    return '\n'.join(problems)


def start_of_file():
    """Return what stands in front of the data of a file with one topic."""
    return MAGIC + record_bytes(
        Header(profile='ros2', library=''),
        Schema(id=1, name='rosgraph_msgs/msg/Clock', encoding='ros2msg',
               data=schema_text('rosgraph_msgs/msg/Clock').encode()),
        Channel(id=1, schema_id=1, topic='/clock', message_encoding='cdr', metadata={}))


def chunk(content, compression, claimed, crc=0):
    """Return a chunk record that claims a size."""
    body = b''.join([bytes(16), claimed.to_bytes(8, 'little'), crc.to_bytes(4, 'little'),
                     len(compression).to_bytes(4, 'little'), compression.encode(),
                     len(content).to_bytes(8, 'little'), content])
    return FRAME.pack(Opcode.CHUNK, len(body)) + body


def zstd_zeros(size):
    """Return zeros in one Zstandard frame, made piece by piece."""
    compressor = zstandard.ZstdCompressor(level=3).compressobj()
    piece = bytes(1 << 20)
    return b''.join(compressor.compress(piece) for _ in range(size >> 20)) + compressor.flush()


BOMBS = {
    'zstd that unpacks to a gigabyte and says so': lambda: chunk(
        zstd_zeros(1 << 30), 'zstd', 1 << 30),
    'zstd that says it is small': lambda: chunk(zstd_zeros(1 << 30), 'zstd', 1000),
    'zstd that says what is just allowed': lambda: chunk(zstd_zeros(1 << 30), 'zstd', 30 << 20),
    'zstd with a window of gigabytes': lambda: chunk(
        b'\x28\xb5\x2f\xfd\x00\xaf' + bytes(33_000), 'zstd', 1 << 20),
    'lz4 that says it is small': lambda: chunk(lz4.frame.compress(bytes(8 << 20)), 'lz4', 1000),
    'lz4 that says terabytes': lambda: chunk(lz4.frame.compress(bytes(8 << 20)), 'lz4', 1 << 42),
    'lz4 of zeros, honest': lambda: chunk(
        lz4.frame.compress(bytes(8 << 20)), 'lz4', 8 << 20, zlib.crc32(bytes(8 << 20))),
    'a million empty messages': lambda: chunk(zstandard.compress(
        MESSAGE.pack(5, 22, 1, 0, 1, 1) * 1_000_000), 'zstd', 31_000_000),
    'a thousand chunks of zeros': lambda: chunk(
        zstandard.compress(bytes(1 << 20)), 'zstd', 1 << 20) * 1000,
    'an unknown compression': lambda: chunk(b'x' * 100, 'bzip2', 100),
    'a chunk whose lengths contradict each other': lambda: chunk(b'', 'lz4', 0)[:-8] + b'\xff' * 8,
}


@pytest.mark.fault(72)
@pytest.mark.parametrize('name', BOMBS)
def test_a_bomb_is_refused_within_two_seconds_and_300_megabytes(tmp_path, name, record_property):
    path = tmp_path / 'bomb.mcap'
    path.write_bytes(start_of_file() + BOMBS[name]())
    read_limited(path, record_property)


@pytest.mark.fault(71)
@pytest.mark.parametrize('length', [0, 1, 2**32, 2**40, 2**63, 2**64 - 1])
@pytest.mark.parametrize('opcode', [0, 1, 3, 4, 5, 6, 7, 9, 12, 15, 16, 128, 255])
def test_a_record_that_claims_an_absurd_length_is_named(tmp_path, opcode, length):
    path = tmp_path / 'a.mcap'
    path.write_bytes(start_of_file() + FRAME.pack(opcode, length) + bytes(100))
    try:
        bag = open_bag(path)
        bag.check()
        assert not bag.complete
    except BagError as problem:
        assert '\n' not in str(problem)


@pytest.mark.fault(71)
def test_a_chunk_in_a_chunk_is_left_out(tmp_path):
    inner = chunk(b'', '', 0)
    (tmp_path / 'a.mcap').write_bytes(start_of_file() + chunk(inner, '', len(inner)))
    assert any('no whole records' in problem for problem in open_bag(tmp_path / 'a.mcap').check())


@pytest.mark.parametrize('data', [
    b'', b'\x89MCAP', b'SQLite format 3\0', b'#ROSBAG V2.0\n' * 9, os.urandom(1000)],
    ids=['empty', 'short', 'db3', 'ros1', 'noise'])
def test_what_is_no_bag_is_named(tmp_path, data):
    (tmp_path / 'a.mcap').write_bytes(data)
    try:
        assert not open_bag(tmp_path / 'a.mcap').complete
    except BagError as problem:
        named = 'not a bag of rosbag2' if data.startswith(b'SQLite') else 'not an MCAP file'
        assert named in str(problem)
    with pytest.raises(InputError, match='no .mcap file in it'):
        (tmp_path / 'none').mkdir()
        open_bag(tmp_path / 'none')
    with pytest.raises(InputError, match='no such bag'):
        open_bag(tmp_path / 'missing')


@pytest.mark.fault(71)
def test_random_bytes_behind_the_start_never_do_worse_than_a_named_problem(tmp_path):
    chosen = random.Random(8)
    path = tmp_path / 'a.mcap'
    for _ in range(300):
        noise = chosen.randbytes(chosen.randrange(400))
        opcode = chosen.choice([3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 15, 2])
        path.write_bytes(start_of_file() + FRAME.pack(opcode, len(noise)) + noise
                         + chosen.choice([b'', MAGIC]))
        contents(path)
