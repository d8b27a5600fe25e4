"""A run as a table or a scene: every state and every number of it, readable by other tools."""

import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.errors import InputError
from ur5_ros.export.export import check_name, export
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.signals import JOINT_NAMES


@pytest.fixture(scope='module')
def golden(repo):
    return load_run(repo / 'bags/golden')


def test_a_csv_gives_every_number_back_to_the_last_bit(golden, tmp_path):
    export(golden, tmp_path / 'run.csv')
    with (tmp_path / 'run.csv').open(newline='') as file:
        header, *rows = csv.reader(file)
    assert len(rows) == len(golden.stamp)
    table = dict(zip(header, np.array(rows).T, strict=True))
    for i, joint in enumerate(JOINT_NAMES):
        for name, unit, values in (('position', 'rad', golden.states.q),
                                   ('velocity', 'rad/s', golden.states.qd),
                                   ('effort', 'N m', golden.states.effort),
                                   ('reference_position', 'rad', golden.reference.q)):
            column = table[f'{name}/{joint} [{unit}]']
            np.testing.assert_array_equal(column.astype(float), values[:, i])
    assert table['stamp [ns]'].astype(np.int64).tolist() == golden.stamp.tolist()
    assert table['tool_error [m]'].astype(float)[-1] < 2e-4


def test_parquet_holds_the_same_columns(golden, tmp_path):
    export(golden, tmp_path / 'run.csv')
    export(golden, tmp_path / 'run.parquet')
    table = polars.read_parquet(tmp_path / 'run.parquet')
    assert table.equals(polars.read_csv(tmp_path / 'run.csv', infer_schema_length=None))


def rerun(*arguments) -> str:
    """Return what Rerun's own command prints about a file."""
    done = subprocess.run([Path(sys.executable).parent / 'rerun', 'rrd', *arguments],
                          capture_output=True, text=True, timeout=100, check=True)
    return done.stdout


def test_a_rerun_recording_holds_the_moving_arm_and_the_curves(golden, tmp_path, capfd):
    export(golden, tmp_path / 'run.rrd')
    assert 'WARN' not in capfd.readouterr().err
    rerun('verify', tmp_path / 'run.rrd')
    text = rerun('stats', tmp_path / 'run.rrd')
    chunks = dict(re.findall(r'^(/\S+): (\d+)$', text.partition('chunks per entity')[2], re.M))
    for joint in JOINT_NAMES:
        for quantity in ('position', 'velocity', 'effort', 'error'):
            assert chunks[f'/{quantity}/{joint}'] == '2', 'its colour, and its values over time'
    turning = [path for path in chunks if path.endswith('_link') and 'inertia/' in path]
    assert len(turning) == 6
    assert all(chunks[path] == '1' for path in turning), 'a static pose would hide the others'
    assert chunks['/urdf'] == '1' and chunks['/arm/base/axes'] == '1'


def test_a_rerun_recording_holds_the_world_and_what_moves_in_it(tmp_path):
    pushed = as_run(run_closed_loop(run_config('push_block', duration=1.6)), 'pushed')
    export(pushed, tmp_path / 'run.rrd')
    text = rerun('stats', tmp_path / 'run.rrd')
    assert {'/world/table', '/world/table/shape', '/world/block',
            '/world/block/shape'} <= set(re.findall(r'^(/\S+): \d+$', text, re.M))


def test_a_rerun_recording_names_what_was_added_to_the_plant_at_its_time(tmp_path):
    loaded = as_run(run_closed_loop(run_config('joint_step', duration=0.5, sim={
        'payload.mass': 2.0, 'friction.viscous': [1.0] * 6})), 'loaded')
    export(loaded, tmp_path / 'run.rrd')
    rerun('verify', tmp_path / 'run.rrd')
    text = rerun('print', '-vvv', '--entity', '/added_to_the_plant', tmp_path / 'run.rrd')
    assert 'payload.mass 2' in text and 'friction.viscous 1' in text


@pytest.mark.parametrize(('name', 'words'), [
    ('run.xlsx', r'\.csv, \.parquet, \.rrd'), ('nowhere/run.csv', 'no such folder'),
    ('there.csv', 'exists')])
def test_a_wrong_name_is_refused_with_the_way_out(tmp_path, name, words):
    (tmp_path / 'there.csv').touch()
    with pytest.raises(InputError, match=words):
        check_name(tmp_path / name)
