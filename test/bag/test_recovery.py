"""Killed recorders: what they leave is whole up to the last 100 ms, and is mended beside it."""

import json
import signal
import statistics
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.recovery import recover
from ur5_ros.errors import BagError, InputError

# Forks recorders of 500 periods a second, notes in shared memory what each has handed over last,
# and ends each with SIGKILL at a random instant.
RECORDERS = """
    import json, mmap, os, random, signal, sys, time
    from pathlib import Path
    import numpy as np
    from ur5_ros.cdr.fixed_messages import FixedJointState, encode_clock
    from ur5_ros.bag.writer import BagWriter
    folder, number, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    chosen = random.Random(seed)
    codec = FixedJointState(['a', 'b', 'c', 'd', 'e', 'f'])

    def record(run, handed_over):
        writer = BagWriter(run / 'sim', {'run': run.name}, max_duration=0.3)
        states = writer.topic('/joint_states', 'sensor_msgs/msg/JointState')
        clock = writer.topic('/clock', 'rosgraph_msgs/msg/Clock')
        values, due, late = np.zeros((3, 6)), time.monotonic(), 0
        while True:
            now = time.monotonic_ns()
            values[0, 0] += 1
            writer.write(clock, now, encode_clock(now))
            writer.write(states, now, codec.encode(now, *values))
            handed_over[8:16] = now.to_bytes(8, 'little')
            if handed_over[0:8] == bytes(8):
                handed_over[0:8] = now.to_bytes(8, 'little')
            # a machine that does not let the loop run does not let the writer run either
            late = max(late, now - round(due * 1e9))
            handed_over[16:24] = late.to_bytes(8, 'little')
            due += 0.002
            time.sleep(max(0.0, due - time.monotonic()))

    last = []
    for kill in range(number):
        run = folder / f'run{kill}'
        handed_over = mmap.mmap(-1, 24)
        child = os.fork()
        if child == 0:
            record(run, handed_over)
        try:
            time.sleep(chosen.uniform(0.02, 0.6))
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        last.append([int.from_bytes(handed_over[at:at + 8], 'little') for at in (0, 8, 16)])
    print(json.dumps(last))
"""


def kill_recorders(folder, number, seed):
    """Kill so many recorders; return first and last stamp handed over and worst delay [ns]."""
    result = subprocess.run(
        [sys.executable, '-c', textwrap.dedent(RECORDERS), str(folder), str(number), str(seed)],
        capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def loss_of(run, first, last):
    """Check what a killed recorder left, before and after mending; return what is lost [ms]."""
    before = {file: file.read_bytes() for file in (run / 'sim').iterdir()}
    bag = open_bag(run / 'sim')
    periods, stamp = [], [first]
    if bag.topics:
        states = bag.joint_states('/joint_states', list('abcdef'))
        periods, stamp = states.position[:, 0].tolist(), states.stamp.tolist() or stamp
    assert not bag.complete
    # what is there is all that there was up to that instant
    assert periods == list(range(1, len(periods) + 1))

    mended = recover(run)
    assert {file: file.read_bytes() for file in (run / 'sim').iterdir()} == before
    assert open_bag(mended.out / 'sim').check() == []
    with AnyReader([mended.out / 'sim']) as reader:
        read = [reader.deserialize(data, connection.msgtype).position[0]
                for connection, _, data in reader.messages()
                if connection.topic == '/joint_states']
    assert read == periods
    return (last - stamp[-1]) / 1e6


def survive(folder, number, seed, record_property):
    """Kill so many recorders and check that at most 100 ms are lost of each."""
    handed_over = kill_recorders(folder, number, seed)
    losses = []
    for kill, (first, last, late) in enumerate(handed_over):
        if last:
            losses.append(loss_of(folder / f'run{kill}', first, last))
            assert losses[-1] <= 100 + late / 1e6
    assert len(losses) > number / 2
    record_property('recorder killed alone, times', len(losses))
    record_property('recorder killed alone, lost [ms]', round(max(losses), 1))
    record_property('recorder killed alone, median lost [ms]',
                    round(statistics.median(losses), 1))


@pytest.mark.fault(80)
def test_a_killed_recorder_loses_100_ms_and_is_repaired(tmp_path, times, record_property):
    survive(tmp_path, times(10, 100), 1, record_property)


@pytest.fixture
def broken(record, tmp_path):
    """Return a run whose control bag was cut off in the middle of its second file."""
    run = tmp_path / 'run'
    record(run / 'sim')
    record(run / 'control', periods=600, max_duration=0.3)
    (run / 'control' / 'metadata.yaml').unlink()
    last = run / 'control' / 'control_1.mcap'
    last.write_bytes(last.read_bytes()[:30_000])
    return run


def tree(folder):
    """Return all files below a folder and their bytes."""
    return {file.relative_to(folder): file.read_bytes()
            for file in folder.rglob('*') if file.is_file()}


def test_repair_keeps_all_that_is_whole_and_leaves_the_original(broken):
    before = tree(broken)
    kept = open_bag(broken / 'control').joint_states('/joint_states')
    mended = recover(broken)
    assert tree(broken) == before
    assert mended.out == broken.with_name('run.recovered') and not mended.intact
    assert tree(mended.out / 'sim') == tree(broken / 'sim')
    bag = open_bag(mended.out / 'control')
    assert np.array_equal(bag.joint_states('/joint_states').position, kept.position)
    assert 300 <= len(kept.stamp) < 600
    assert bag.check() == [] and bag.description == open_bag(broken / 'control').description
    assert 'unfinished' in ' '.join(bag.notes['recovery']['problems'])
    for file in (mended.out / 'control').glob('*.mcap'):
        with open(file, 'rb') as stream:
            reader = make_reader(stream, validate_crcs=True)
            assert sum(1 for _ in reader.iter_messages()) \
                == reader.get_summary().statistics.message_count
    assert [bag.name for bag in mended.bags if bag.problems] == ['control']
    assert str(mended.out) in mended.sentences()[-1]


@pytest.mark.fault(80)
def test_repair_twice_gives_the_same_and_a_repaired_bag_needs_none(broken):
    once = tree(recover(broken).out)
    again = recover(broken)
    assert tree(again.out) == once
    assert recover(again.out).out is None
    assert not list(broken.parent.glob('*.unfinished'))


def test_a_whole_run_is_not_changed(recorded):
    mended = recover(recorded.folder)
    assert mended.intact and mended.out is None
    assert not recorded.folder.with_name('bag.recovered').exists()


def test_another_folder_in_the_way_is_refused(broken):
    (broken.with_name('run.recovered')).mkdir()
    (broken.with_name('run.recovered') / 'mine.txt').write_text('keep')
    with pytest.raises(InputError, match='holds something else'):
        recover(broken)
    assert (broken.with_name('run.recovered') / 'mine.txt').read_text() == 'keep'
    assert recover(broken, broken.with_name('elsewhere')).out == broken.with_name('elsewhere')


@pytest.mark.fault(75)
def test_a_lost_metadata_yaml_is_rebuilt(recorded):
    written = (recorded.folder / 'metadata.yaml').read_text()
    (recorded.folder / 'metadata.yaml').unlink()
    mended = recover(recorded.folder)
    assert (mended.out / 'metadata.yaml').read_text() == written


def test_a_single_file_and_a_bag_of_another_writer_are_repaired_too(recorded, tmp_path):
    file = tmp_path / 'loose.mcap'
    data = (recorded.folder / 'bag_0.mcap').read_bytes()
    file.write_bytes(data[:len(data) * 3 // 4])
    mended = recover(file)
    assert mended.out == tmp_path / 'loose.recovered'
    assert open_bag(mended.out).check() == []
    assert file.read_bytes() == data[:len(data) * 3 // 4]


@pytest.mark.fault(70, 80)
@pytest.mark.parametrize('place', ['content', 'kind', 'length', 'small length'])
def test_a_damaged_chunk_in_the_middle_costs_only_that_chunk(record, tmp_path, place):
    folder = record(tmp_path / 'bag', periods=1000).folder
    file = folder / 'bag_0.mcap'
    data = bytearray(file.read_bytes())
    with open(file, 'rb') as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[1].chunk_start_offset
    at, bit = {'content': (3000, 1), 'kind': (0, 1), 'length': (5, 1),
               'small length': (1, 4)}[place]
    data[chunk + at] ^= bit
    file.write_bytes(data)
    bag = open_bag(folder)
    states = bag.joint_states('/joint_states')
    assert 0 < 1000 - len(states.stamp) <= 200 and not bag.complete
    assert np.array_equal(open_bag(recover(folder).out).joint_states('/joint_states').position,
                          states.position)


def test_a_run_of_which_nothing_is_readable_is_named(tmp_path):
    (tmp_path / 'run' / 'sim').mkdir(parents=True)
    (tmp_path / 'run' / 'sim' / 'sim_0.mcap').write_bytes(b'noise' * 100)
    with pytest.raises(BagError, match='not an MCAP file'):
        recover(tmp_path / 'run')
    with pytest.raises(InputError, match='no such folder'):
        recover(tmp_path / 'missing')
    with pytest.raises(InputError, match='no bag in it'):
        recover(tmp_path)


RECOVER = 'import sys; from ur5_ros.bag.recovery import recover; recover(sys.argv[1])'


@pytest.mark.fault(80)
def test_two_recoveries_at_once_agree(broken):
    children = [subprocess.Popen([sys.executable, '-c', RECOVER, str(broken)],
                                 stderr=subprocess.PIPE) for _ in range(2)]
    try:
        assert [child.wait(60) for child in children] == [0, 0]
    finally:
        for child in children:
            child.kill()
            child.communicate()
    assert open_bag(broken.with_name('run.recovered') / 'control').check() == []
    assert not list(broken.parent.glob('*.unfinished'))


@pytest.mark.fault(80)
def test_a_killed_recovery_leaves_nothing_that_looks_whole_and_the_next_one_succeeds(broken):
    before = tree(broken)
    kill_in_rename = RECOVER.replace('recover(sys', 'import os, signal, pathlib; pathlib.Path.'
                                     'rename = lambda *_: os.kill(os.getpid(), signal.SIGKILL); '
                                     'recover(sys')
    result = subprocess.run([sys.executable, '-c', kill_in_rename, str(broken)], timeout=60)
    assert result.returncode == -signal.SIGKILL
    assert not broken.with_name('run.recovered').exists() and tree(broken) == before
    assert len(list(broken.parent.glob('*.unfinished'))) == 1
    assert recover(broken).out.is_dir()
    assert not list(broken.parent.glob('*.unfinished'))
