"""Names and places of runs, and what a machine's fingerprint is made of."""

import os
import re

import pytest

from ur5_ros.bag.fingerprint import fingerprint, processor_features
from ur5_ros.bag.run_folders import bags_of_run, new_run_name, newest_run
from ur5_ros.errors import InputError


def test_run_names_are_utc_times_with_four_characters_and_differ():
    names = {new_run_name() for _ in range(50)}
    assert len(names) > 45
    assert all(re.fullmatch(r'\d{8}T\d{6}Z-[a-z0-9]{4}', name) for name in names)


def test_the_newest_run_is_the_one_written_to_last(tmp_path):
    for age, run in enumerate(('c', 'a', 'b')):
        file = tmp_path / run / 'sim' / 'sim_0.mcap'
        file.parent.mkdir(parents=True)
        file.write_bytes(b'')
        os.utime(file, (1000 - age, 1000 - age))
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'x.1.unfinished' / 'sim').mkdir(parents=True)
    assert newest_run(tmp_path) == tmp_path / 'c'


def test_no_run_is_refused_with_the_way_out(tmp_path):
    for folder in (tmp_path, tmp_path / 'missing'):
        with pytest.raises(InputError, match='ur5 demo'):
            newest_run(folder)


def test_the_bags_of_a_run_are_its_folders_or_the_bag_itself(record, tmp_path):
    record(tmp_path / 'run' / 'sim', periods=1)
    record(tmp_path / 'run' / 'control', periods=1)
    (tmp_path / 'run' / 'notes').mkdir()
    assert [bag.name for bag in bags_of_run(tmp_path / 'run')] == ['control', 'sim']
    assert bags_of_run(tmp_path / 'run' / 'sim') == [tmp_path / 'run' / 'sim']


def test_the_fingerprint_is_flat_text_and_the_same_when_asked_again():
    found = fingerprint()
    assert found == fingerprint()
    assert {'python', 'numpy', 'numba', 'pybullet', 'processor', 'machine'} <= set(found)
    assert all(isinstance(value, str) and value for value in found.values())


def test_processor_features_come_in_a_fixed_order(tmp_path):
    (tmp_path / 'cpuinfo').write_text('model name : x\nflags\t\t: fma sse4_2 fpu avx2 avx\n')
    assert processor_features(tmp_path / 'cpuinfo') == 'sse4_2 avx avx2 fma'
    assert processor_features(tmp_path / 'missing')
