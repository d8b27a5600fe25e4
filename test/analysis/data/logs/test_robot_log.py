"""A robot's own log becomes a bag that is judged and identified like any other."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.logs.robot_log import COLUMNS, import_log
from ur5_ros.analysis.data.logs.table import read_table
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics

REAL = Path(__file__).resolve().parents[5] / 'shared' / 'real_ur5'
MOTIONS = ('motion3_fast', 'motion5_slow', 'motion6_long', 'motion7_short')


def table(n=400):
    """Return a log of arm ur5_real that moves all joints at 125 Hz, as columns."""
    t = np.arange(n) / 125.0
    w, a = np.arange(1, 7) * 1.1, 0.3
    q = a * np.sin(np.outer(t, w)) + np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
    qd, qdd = a * w * np.cos(np.outer(t, w)), -a * w**2 * np.sin(np.outer(t, w))
    torque = inverse_dynamics(q, qd, qdd, load_arm('ur5_real'))
    return {'q': q, 'qd': qd, 'torque': torque, 'q_star': q, 'qd_star': qd, 'qdd_star': qdd,
            'current': torque / 10.0, 'tool': np.zeros((n, 6))}, t


def text(style=0, separator=',', spoil=lambda lines: lines, leave=()):
    values, t = table()
    kept = {name: value for name, value in values.items() if name not in leave}
    names = [('t', 'timestamp')[style]] + [
        COLUMNS[name][style].format(i, i + 1) for name in kept for i in range(6)]
    rows = np.column_stack([t, *kept.values()])
    lines = [separator.join(names)] + [separator.join(f'{x:.9g}' for x in row) for row in rows]
    return '\n'.join(spoil(lines)) + '\n'


@pytest.mark.parametrize('style, separator', [(0, ','), (1, ','), (1, ' '), (0, ';')])
@pytest.mark.parametrize('zipped', [False, True])
def test_both_forms_of_log_become_the_same_run(tmp_path, style, separator, zipped):
    log = tmp_path / 'log.csv'
    data = text(style, separator).encode()
    log.write_bytes(gzip.compress(data) if zipped else data)
    import_log(log, tmp_path / 'run', 'ur5_real')
    run = load_run(tmp_path / 'run')
    values, t = table()
    np.testing.assert_allclose(run.states.q, values['q'], atol=1e-8)
    np.testing.assert_allclose(run.reference.qdd, values['qdd_star'], atol=1e-7)
    np.testing.assert_allclose(run.current, values['current'], atol=1e-7)
    np.testing.assert_allclose(run.t, t, atol=1e-8)
    result = validate(run)
    assert result.check('inverse dynamics').verdict == 'pass'
    wrong = validate(load_run(tmp_path / 'run', arm='ur5'))
    assert wrong.verdict == 'fail' and wrong.causes[0]['kind'] == 'armature'


def at(line, change):
    def spoil(lines):
        lines[line] = change(lines[line])
        return lines
    return spoil


@pytest.mark.parametrize('spoil, reason', [
    (at(0, lambda line: line.replace('q_actual_3', 'q_actual_x')), 'no column q_actual_3 '),
    (lambda lines: [line.replace('q_actual', 'p') for line in lines], 'no columns q_actual_1..6'),
    (at(0, lambda line: line.replace('t,', 'clock,', 1)), 'no column t or timestamp or time'),
    (at(0, lambda line: line.replace('q_target_2', 'q_target_1')), 'stands twice'),
    (lambda lines: lines[1:], 'without names; name them.*--columns'),
    (lambda lines: lines[:1] + [line.replace('.', '.x') for line in lines[1:]],
     '0 of 400 rows can be used.*no numbers: dropped .first: line 2'),
    (lambda lines: lines[:1], 'at least two whole rows'),
    (lambda lines: lines[:2], 'at least two whole rows'),
    (lambda lines: [], 'is empty')])
def test_a_bad_log_is_refused_by_line_or_column(tmp_path, spoil, reason):
    log = tmp_path / 'log.csv'
    log.write_text(text(spoil=spoil))
    with pytest.raises(InputError, match=reason):
        import_log(log, tmp_path / 'run')
    assert not (tmp_path / 'run').exists()


def cell(line, column, value):
    """Return a change of one cell of a line."""
    def spoil(lines):
        cells = lines[line].split(',')
        cells[column] = value
        lines[line] = ','.join(cells)
        return lines
    return spoil


@pytest.mark.parametrize('spoil, reason, rows', [
    (cell(5, 1, 'nan'), '1 row of 400 holds a value that is no number or impossible.*line 6', 399),
    (cell(5, 1, '5.9e293'), '1 row of 400 holds a value that is no number or impossible', 399),
    (cell(5, 1, 'inf'), '1 row of 400 holds a value that is no number or impossible', 399),
    (cell(5, 1, 'abc'), '1 row of 400 is cut off or no numbers.*line 6', 399),
    (at(9, lambda line: line.rpartition(',')[0]), '1 row of 400 is cut off.*line 10', 399),
    (at(400, lambda line: line[:40]), '1 row of 400 is cut off.*line 401', 399),
    (cell(7, 0, '0.0'), '1 row of 400 goes back in time.*line 8', 399),
    (lambda lines: lines[:1] + [each for line in lines[1:] for each in (line, line)],
     '400 rows of 800 repeat the time', 400)])
def test_rows_that_do_not_count_are_dropped_and_counted_by_line(tmp_path, spoil, reason, rows):
    (tmp_path / 'log.csv').write_text(text(spoil=spoil))
    sentences = import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5_real')
    assert re.search(reason, '; '.join(sentences))
    run = load_run(tmp_path / 'run')
    assert len(run.stamp) == rows and re.search(reason, '; '.join(run.remarks))
    result = validate(run)
    assert result.check('inverse dynamics').verdict == 'pass'
    assert result.check('timing').verdict == 'pass'  # a dropped row is no gap of the recorder


def with_column(place, name, value):
    """Return a change that adds a column of one text."""
    def spoil(lines):
        out = []
        for i, line in enumerate(lines):
            cells = line.split(',')
            cells.insert(place, name if i == 0 else value)
            out.append(','.join(cells))
        return out
    return spoil


@pytest.mark.parametrize('spoil', [
    with_column(1, 'safety', 'NORMAL'), with_column(3, 'ok', 'True'),
    with_column(1, 'note', '"a b"'), with_column(1, 'empty', ''),
    at(0, lambda line: line.replace('t,', 'time,', 1)),
    at(0, lambda line: '# ' + line), lambda lines: ['', *lines, '', ''],
    lambda lines: [line + '\r' for line in lines]])
def test_only_the_columns_that_are_used_are_parsed(tmp_path, spoil):
    (tmp_path / 'log.csv').write_text(text(spoil=spoil), newline='')
    import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5_real')
    run = load_run(tmp_path / 'run')
    np.testing.assert_allclose(run.states.q, table()[0]['q'], atol=1e-8)
    assert run.remarks == ()


@pytest.mark.parametrize('separator', [';', '\t'])
def test_a_decimal_comma_is_read(tmp_path, separator):
    (tmp_path / 'log.csv').write_text(text(1, separator).replace('.', ','))
    import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5_real')
    np.testing.assert_allclose(load_run(tmp_path / 'run').states.q, table()[0]['q'], atol=1e-8)


@pytest.mark.parametrize('columns', [
    'timestamp,actual_q,actual_qd,target_moment',
    'timestamp,' + ','.join(f'{name}_{i}' for name in ('actual_q', 'actual_qd', 'target_moment')
                            for i in range(6)),
    'timestamp,actual_q,' + '-,' * 6 + 'target_moment'])
def test_a_log_without_names_is_read_by_those_of_the_option(tmp_path, columns):
    lines = text(1, leave=('q_star', 'qd_star', 'qdd_star', 'current', 'tool')).split('\n')[1:]
    (tmp_path / 'log.csv').write_text('\n'.join(lines))
    import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5_real', columns)
    run = load_run(tmp_path / 'run')
    np.testing.assert_allclose(run.states.effort, table()[0]['torque'], atol=1e-6)
    assert ('no velocity is measured' in '; '.join(run.remarks)) == ('-,' in columns)
    with pytest.raises(InputError, match='names 1 column; the log has 19'):
        read_table(tmp_path / 'log.csv', 'timestamp')


def test_a_declared_payload_becomes_part_of_the_arm(tmp_path):
    def loaded(lines):
        return [line + (',payload,payload_cog_0,payload_cog_1,payload_cog_2' if i == 0 else
                        ',1.28,0.01,0.0,0.05') for i, line in enumerate(lines)]
    (tmp_path / 'log.csv').write_text(text(1, spoil=loaded))
    sentences = import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5_real')
    assert any('declared payload: 1.28 kg' in sentence for sentence in sentences)
    payload = load_run(tmp_path / 'run').required_control.arm.payload
    assert payload.mass == 1.28 and payload.com.tolist() == [0.01, 0.0, 0.05]


def test_a_log_that_is_no_text_or_absent_is_refused(tmp_path):
    (tmp_path / 'a.csv').write_bytes(bytes(range(256)))
    (tmp_path / 'b.csv.gz').write_bytes(gzip.compress(text().encode())[:90])
    for name in ('a.csv', 'b.csv.gz', 'absent.csv'):
        with pytest.raises(InputError):
            read_table(tmp_path / name)


def test_a_log_without_torques_is_imported_and_said_so(tmp_path):
    (tmp_path / 'log.csv').write_text(text(leave=('torque', 'current')))
    sentences = import_log(tmp_path / 'log.csv', tmp_path / 'run')
    assert any('not in the log' in sentence and 'm_target_1..6' in sentence
               for sentence in sentences)
    result = validate(load_run(tmp_path / 'run'))
    assert result.check('inverse dynamics').verdict == 'not applicable'
    assert result.check('kinematics').verdict == 'pass' and result.verdict == 'pass'


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / 'log.csv').write_text(text())
    (tmp_path / 'run').mkdir()
    with pytest.raises(InputError, match='exists already'):
        import_log(tmp_path / 'log.csv', tmp_path / 'run')


@pytest.fixture(scope='module')
def real(tmp_path_factory):
    if not REAL.is_dir():
        pytest.skip(f'no recordings of a real UR5 at {REAL}')
    folder = tmp_path_factory.mktemp('real')
    for motion in MOTIONS:
        import_log(REAL / f'{motion}.csv.gz', folder / motion)
    return folder


@pytest.mark.parametrize('motion', MOTIONS)
def test_the_residual_of_arm_ur5_on_a_real_robot_is_rotor_inertia_and_gravity(real, motion):
    own = validate(load_run(real / motion))
    assert own.check('inverse dynamics').verdict == 'pass'
    result = validate(load_run(real / motion, arm='ur5'))
    assert result.check('inverse dynamics').verdict == 'fail'
    sentence = result.causes[0]['sentence']
    assert 'rotor inertia of link 1 is 1.915' in sentence
    assert '-9.82 m/s^2 instead of -9.81' in sentence
    assert result.causes[0]['share'] > 0.999


def test_friction_identified_on_three_motions_serves_on_the_fourth(real):
    runs = [load_run(real / motion) for motion in MOTIONS]
    found = identify(runs[1:], load_arm('ur5_controller'), runs[0])
    assert found.test_rms.max() < 1e-4  # of up to 89 N m
    motors = found.motors
    assert np.all(motors.with_[:5] < 0.75 * motors.without[:5])
    assert np.all(motors.coulomb[:3] > 5.0) and np.all(motors.coulomb[:3] < 9.0)
    assert np.all(motors.coulomb > motors.coulomb_error)
    assert any('not on wrist_3_joint' in sentence for sentence in found.sentences())
