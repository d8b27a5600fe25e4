"""A robot's log in the forms of recorders and spreadsheets: the same numbers are read."""

import gzip
import re
from datetime import UTC, datetime

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.logs.robot_log import import_log
from ur5_ros.analysis.data.logs.table import read_table
from ur5_ros.analysis.validate import validate
from ur5_ros.errors import InputError

N, START = 120, 1_780_000_000.0
T = np.arange(N) * 0.002
W = np.arange(1.0, 7.0)
Q, QD = 0.5 * np.sin(np.outer(T, W)) - 1.0, 0.5 * W * np.cos(np.outer(T, W))
TORQUE = 20.0 * Q
NAMES = ['timestamp', *(f'{name}_{i}' for name in ('actual_q', 'actual_qd', 'target_moment')
                        for i in range(6))]


def lines(separator=',', names=NAMES, scale=1.0, start=START, q=Q, qd=QD, form='{:.6f}'):
    """Return the lines of a log, the names first."""
    rows = [separator.join([form.format((start + t) * scale),
                            *(f'{x:.10g}' for x in (*a, *b, *c))])
            for t, a, b, c in zip(T, q, qd, TORQUE, strict=True)]
    return [separator.join(names), *rows]


def read(tmp_path, text, columns=None):
    data = text if isinstance(text, bytes) else '\n'.join(text).encode()
    (tmp_path / 'log.csv').write_bytes(data)
    return read_table(tmp_path / 'log.csv', columns)


def quoted(rows):
    return [','.join(f'"{cell.replace(".", ",")}"' for cell in row.split(',')) for row in rows]


def vectors(left, right, between, separator=','):
    """Return a log in which each six numbers are one cell."""
    rows = [separator.join(('timestamp', 'actual_q', 'actual_qd', 'target_moment'))]
    for row in lines()[1:]:
        time, *cells = row.split(',')
        rows.append(separator.join([time, *(
            left + between.join(cells[k:k + 6]) + right for k in (0, 6, 12))]))
    return rows


def renamed(change):
    return lines(names=[change(name) for name in NAMES])


FORMS = {
    'bars': lines('|'), 'bars and spaces': lines(' | '), 'several spaces': lines('   '),
    'a comma and a space': lines(', '), 'carriage returns': '\r'.join(lines()).encode(),
    'a mark of UTF-8': b'\xef\xbb\xbf' + '\r\n'.join(lines(';')).encode(),
    'UTF-16': '\r\n'.join(lines('\t')).encode('utf-16'),
    'a note that is not UTF-8': '\n'.join(
        [f'{line},f\xfcr' for line in lines()]).encode('latin-1'),
    'decimal commas between spaces': [line.replace('.', ',') for line in lines(' ')],
    'quoted decimal commas': [lines()[0], *quoted(lines()[1:])],
    'quoted names': quoted(lines()[:1]) + lines()[1:],
    'a line for a spreadsheet': ['sep=;', *lines(';')],
    'comments before the names': ['# UR5e', '# 500 Hz, base, tool', '', *lines()],
    'text before the names': ['UR5e log', 'arm: a, b', *lines()],
    'comments between rows': [*lines()[:50], '# pause', '% pause', *lines()[50:]],
    'a separator behind each row': [lines()[0], *(f'{row},' for row in lines()[1:])],
    'a separator behind every line': [f'{line},' for line in lines()],
    'a separator behind the names': [f'{lines()[0]},', *lines()[1:]],
    'a column without a name': [f',{lines()[0]}', *(f'{i},{row}' for i, row
                                                    in enumerate(lines()[1:]))],
    'brackets': renamed(lambda name: re.sub(r'_(\d)', r'[\1]', name)),
    'capitals': renamed(str.upper), 'no line between': renamed(
        lambda name: re.sub(r'_(\d)', r'\1', name)),
    'counted from 1': renamed(lambda name: re.sub(
        r'\d', lambda found: str(int(found[0]) + 1), name)),
    'SI units in the names': renamed(lambda name: name + {
        't': ' [s]', 'a': ' (rad/s)' if 'qd' in name else ' (rad)'}[name[0]]
        if 'moment' not in name else f'{name} [N m]'),
    'a row of units': [lines()[0], ','.join(['s'] + ['rad'] * 6 + ['rad/s'] * 6 + ['Nm'] * 6),
                       *lines()[1:]],
    'vectors of a list': vectors('"[', ']"', ', '), 'vectors of NumPy': vectors('[', ']', ' '),
    'vectors and semicolons': vectors('[', ']', ', ', ';'),
    'degrees by name': lines(q=np.degrees(Q), qd=np.degrees(QD), names=[
        name + ('[deg/s]' if 'qd' in name else '[deg]' if '_q' in name else '')
        for name in NAMES]),
    'milliseconds by name': lines(scale=1e3, names=['timestamp_ms', *NAMES[1:]]),
    'milliseconds': lines(scale=1e3, start=0.0), 'microseconds': lines(scale=1e6, start=0.0),
    'milliseconds since 1970': lines(scale=1e3), 'microseconds since 1970': lines(scale=1e6),
    'nanoseconds since 1970': lines(scale=1e9, form='{:.0f}'),
    'a minus sign of a text program': [lines()[0], *(row.replace('-', '\N{MINUS SIGN}')
                                                     for row in lines()[1:])],
    'UTF-32': '\n'.join(lines()).encode('utf-32'),
    'two compressed parts': gzip.compress('\n'.join(lines()[:50]).encode() + b'\n')
    + gzip.compress('\n'.join(lines()[50:]).encode()),
    'the time in the last column': [','.join([*row.split(',')[1:], row.split(',')[0]])
                                    for row in lines()],
    'dates': [lines()[0], *(','.join([datetime.fromtimestamp(
        float(row.split(',')[0]), UTC).isoformat(), row.partition(',')[2]])
        for row in lines()[1:])],
}


@pytest.mark.parametrize('how', FORMS)
def test_every_form_is_read_as_the_same_numbers(tmp_path, how):
    found = read(tmp_path, FORMS[how])
    np.testing.assert_allclose(found.values['q'], Q, atol=1e-8)
    np.testing.assert_allclose(found.values['qd'], QD, atol=1e-8)
    np.testing.assert_allclose(found.values['torque'], TORQUE, atol=1e-7)
    np.testing.assert_allclose(found.t - found.t[0], T, atol=1e-6)
    assert [remark for remark in found.remarks if 'the time is in' not in remark] == []


@pytest.mark.parametrize('scale, unit', [(1e3, 'ms'), (1e6, 'us')])
def test_without_velocities_the_unit_of_the_time_is_known_by_the_rate(tmp_path, scale, unit):
    cut = [','.join(line.split(',')[:7]) for line in lines(scale=scale, start=0.0)]
    found = read(tmp_path, cut)
    assert found.remarks == [f'the time is in {unit}, as the motion shows']
    np.testing.assert_allclose(found.t, T, atol=1e-9)


REFUSED = {
    'a column is missing': (
        [','.join(line.split(',')[:6] + line.split(',')[7:]) for line in lines()],
        'no column actual_q_5 '),
    'degrees without a name': (lines(q=np.degrees(Q - 1.0), qd=np.degrees(QD)),
                               r'line \d+: joint \d is at -\d+.* rad, .*degrees.*\[deg\]'),
    'another unit': (renamed(lambda name: name.replace('actual_q_2', 'actual_q_2 (grad)')),
                     "'grad' is not one of rad"),
    'two units': (renamed(lambda name: name.replace('actual_q_2', 'actual_q_2 (deg)').replace(
        'actual_q_3', 'actual_q_3 (rad)')), 'is not one of rad'),
    'rows wider than the names': ([lines()[0], *(f'1,{row}' for row in lines()[1:])],
                                  'the names are 19, the first row has 20 columns'),
    'one time throughout': ([lines()[0], *(f'1,{row.partition(",")[2]}' for row in lines()[1:])],
                            '1 of 120 rows can be used.*repeat the time'),
    'a page': (['<html>', '<body>hello, world</body>'], 'no column t or timestamp or time'),
    'UTF-16 without a mark': ('\n'.join(lines()).encode('utf-16-le'), 'not a text file'),
}


@pytest.mark.parametrize('how', REFUSED)
def test_what_cannot_be_read_is_refused_with_column_value_and_way_out(tmp_path, how):
    text, match = REFUSED[how]
    with pytest.raises(InputError, match=match) as caught:
        read(tmp_path, text)
    assert '\n' not in str(caught.value) and 'log.csv' in str(caught.value)


@pytest.mark.parametrize('spoil', [
    lambda row: row.rpartition(',')[0] + ',nan', lambda row: row.rpartition(',')[0] + ',',
    lambda row: ','.join(row.split(',')[:-1])])
def test_a_quantity_that_most_rows_lack_is_left_out_and_said(tmp_path, spoil):
    whole = lines()
    short = spoil(whole[1]).count(',') < whole[1].count(',')
    found = read(tmp_path, [spoil(whole[0]) if short else whole[0],
                            *(spoil(row) for row in whole[1:])])
    assert 'torque' not in found.values and len(found.t) == N
    assert 'target_moment_5' in '; '.join(found.remarks)


def test_degrees_may_be_stated_by_the_option(tmp_path):
    found = read(tmp_path, lines(q=np.degrees(Q), qd=np.degrees(QD))[1:],
                 'timestamp,actual_q [deg],actual_qd [deg/s],target_moment')
    np.testing.assert_allclose(found.values['q'], Q, atol=1e-8)
    np.testing.assert_allclose(found.values['qd'], QD, atol=1e-8)


def test_temperatures_of_the_joints_come_with_the_run(tmp_path):
    warm = 25.0 + np.outer(T, np.arange(1.0, 7.0))
    names = [*NAMES, *(f'joint_temperatures_{i}' for i in range(6))]
    rows = [f'{row},{",".join(map(str, each))}'
            for row, each in zip(lines()[1:], warm, strict=True)]
    (tmp_path / 'log.csv').write_text('\n'.join([','.join(names), *rows]))
    import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5e')
    run = load_run(tmp_path / 'run')
    assert run.temperature is not None and run.temperature.shape == (N, 6)
    np.testing.assert_allclose(run.temperature[0], 25.0)  # recorded once a second
    assert validate(run).check('kinematics').verdict == 'pass'


def stamps(seconds, nanoseconds):
    """Return a log with seconds and nanoseconds in columns of these names."""
    rows = [f'1780000000,{round(t * 1e9)},{row.partition(",")[2]}'
            for t, row in zip(T, lines()[1:], strict=True)]
    return [f'{seconds},{nanoseconds},{lines()[0].partition(",")[2]}', *rows]


CHOSEN = {
    'elapsed_time': renamed(lambda name: name.replace('timestamp', 'elapsed_time')),
    'robot_time': renamed(lambda name: name.replace('timestamp', 'Robot time [s]')),
    'sec and nanosec': stamps('sec', 'nanosec'),
    'header_stamp_sec and header_stamp_nanosec': stamps('header.stamp.sec',
                                                        'header.stamp.nanosec'),
}


@pytest.mark.parametrize('names', CHOSEN)
def test_a_time_of_another_name_is_taken_and_named(tmp_path, names):
    found = read(tmp_path, CHOSEN[names])
    np.testing.assert_allclose(found.t - found.t[0], T, atol=1e-6)
    assert len(found.remarks) == 1 and found.remarks[0].endswith(names)


OUT_OF_ORDER = {
    'backwards': ([lines()[0], *lines()[:0:-1]], 'turned round', N),
    'one row ahead': ([*lines()[:50], lines()[80], *lines()[51:]],
                      '1 row of 120 goes back in time, or ahead.*line 51', N - 1),
    'two rows swapped': ([*lines()[:50], lines()[51], lines()[50], *lines()[52:]],
                         '1 row of 120 goes back in time.*line 51', N - 1),
    'a second recording, shorter': ([*lines(), *lines(start=START - 9.0)[1:41]],
                                    '40 rows of 160 are of another recording.*line 122', N),
    'a second recording, longer': ([*lines(start=START + 0.1)[:41], *lines()[1:]],
                                   '40 rows of 160 are of another recording.*line 2', N),
    'three recordings': ([*lines()[:41], *lines()[1:], *lines()[1:41]],
                         '80 rows of 200 are of another recording.*line 2', N),
    'the names again between rows': ([*lines()[:61], lines()[0], *lines()[61:]],
                                     "line 62: timestamp = 'timestamp'", N),
}


@pytest.mark.parametrize('how', OUT_OF_ORDER)
def test_of_rows_out_of_order_the_longest_recording_is_taken(tmp_path, how):
    text, reason, rows = OUT_OF_ORDER[how]
    found = read(tmp_path, text)
    assert re.search(reason, '; '.join(found.remarks)) and len(found.t) == rows
    assert np.all(np.diff(found.t) > 0.0)
    which = np.rint((found.t - found.t[0]) / 0.002).astype(int)
    np.testing.assert_allclose(found.values['q'], Q[which], atol=1e-8)


@pytest.mark.parametrize('spoil, whole', [
    (lambda data: data[:-200], False), (lambda data: data + b'noise', True),
    (lambda data: data[:5000] + bytes(300) + data[5300:], False)])
def test_a_damaged_compressed_log_is_read_as_far_as_it_goes(tmp_path, spoil, whole):
    found = read(tmp_path, spoil(gzip.compress('\n'.join(lines()).encode())))
    assert any('compressed file is cut or damaged' in remark for remark in found.remarks)
    assert len(found.t) == N if whole else N // 4 < len(found.t) < N
    np.testing.assert_allclose(found.values['q'], Q[:len(found.t)], atol=1e-8)


def test_a_gap_does_not_change_the_unit_of_the_time(tmp_path):
    late = [','.join([f'{float(row.split(",")[0]) + 1e6:.6f}', row.partition(',')[2]])
            for row in lines(start=0.0)[61:]]
    found = read(tmp_path, [*lines(start=0.0)[:61], *late])
    assert found.remarks == [] and found.t[-1] == pytest.approx(1e6 + T[-1])


@pytest.mark.parametrize('stamp', ['15:00:00.004', '27.11.2026 15:00:00', '11/27/2026 3:00 PM'])
def test_a_cell_that_is_no_number_is_named_with_its_column(tmp_path, stamp):
    with pytest.raises(InputError, match=re.escape(f"line 2: timestamp = '{stamp}'")):
        read(tmp_path, [lines()[0], *(f'{stamp},{row.partition(",")[2]}'
                                      for row in lines()[1:])])


@pytest.mark.parametrize('value, reason', [('-1', 'declared payload is -1 kg'),
                                         ('nan', 'payload has numbers in 0% of the rows')])
def test_a_payload_that_none_can_be_is_left_out_and_said(tmp_path, value, reason):
    (tmp_path / 'log.csv').write_text('\n'.join(
        f'{row},{value if i else "payload"}' for i, row in enumerate(lines())))
    sentences = '; '.join(import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5e'))
    assert reason in sentences and 'its six' not in sentences
    assert load_run(tmp_path / 'run').required_control.arm.payload.mass == 0.0


def test_a_few_angles_that_no_joint_has_are_dropped_and_many_are_another_unit(tmp_path):
    far = Q.copy()
    far[[30, 70], [0, 3]] = [253.0, -1e3]
    found = read(tmp_path, lines(q=far))
    assert found.remarks == ['2 rows of 120 hold an angle further than any joint turns: dropped '
                             '(first: line 32)']
    np.testing.assert_allclose(found.values['q'], np.delete(Q, [30, 70], axis=0), atol=1e-8)
    far[:10, 1] = 90.0
    with pytest.raises(InputError, match='and so are 12 rows of 120; if these are degrees'):
        read(tmp_path, lines(q=far))


MEASURED = ['actual_current_as_torque', 'actual_torque', 'actual_moment', 'joint_torques',
            'effort']


@pytest.mark.parametrize('name', MEASURED)
def test_a_measured_torque_is_used_where_there_is_no_target_torque(tmp_path, name):
    text = renamed(lambda each: each.replace('target_moment', name))
    (tmp_path / 'log.csv').write_text('\n'.join(text))
    sentences = import_log(tmp_path / 'log.csv', tmp_path / 'run', 'ur5e')
    assert 'effort = torque that the robot measured' in sentences
    run = load_run(tmp_path / 'run')
    np.testing.assert_allclose(run.states.effort, TORQUE, rtol=1e-8)
    assert not run.follows_reference


def test_of_a_target_torque_and_a_measured_one_the_target_torque_is_used(tmp_path):
    both = [f'{row},{",".join(f"actual_torque_{i}" if k == 0 else "7" for i in range(6))}'
            for k, row in enumerate(lines())]
    (tmp_path / 'log.csv').write_text('\n'.join(both))
    assert any('target torque' in each for each in import_log(
        tmp_path / 'log.csv', tmp_path / 'run', 'ur5e'))
    np.testing.assert_allclose(load_run(tmp_path / 'run').states.effort, TORQUE, rtol=1e-8)


def test_columns_that_may_be_torques_and_are_not_used_are_named(tmp_path):
    found = read(tmp_path, renamed(lambda each: each.replace('target_moment', 'tau_hat')))
    assert found.remarks == ["columns that may be torques are not used: 'tau_hat_0, tau_hat_1, "
                             "tau_hat_2, tau_hat_3'; name them with --columns"]


def test_a_recorder_that_is_faster_than_the_robot_repeats_rows_and_loses_none(tmp_path):
    names, *rows = lines()
    found = read(tmp_path, [names, *(row for row in rows for _ in range(4))])
    assert len(found.t) == N
    assert found.remarks == ['360 rows of 480 repeat the time of the row before: dropped (first: '
                             'line 3)']
