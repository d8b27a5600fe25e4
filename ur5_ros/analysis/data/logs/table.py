"""The rows of a robot's log that count, as numbers in SI units."""

from datetime import datetime
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.logs.columns import COLUMNS, LARGEST, LogColumns, find_columns
from ur5_ros.analysis.data.logs.text import LogText, cells_of, number, read_log
from ur5_ros.analysis.data.logs.time_unit import seconds_of
from ur5_ros.errors import InputError

#: Share of the rows that must count.
LEAST_SHARE = 0.5

#: A joint turns no further than this [rad]; wrist 3 of some arms does.
FURTHEST, MAY_TURN = 13.0, 5


class LogTable(NamedTuple):
    """The rows of a log that count."""

    t: np.ndarray
    """Time [s], shape (n,), increasing."""
    values: dict[str, np.ndarray]
    """Quantity -> shape (n, k), of those that the log has."""
    remarks: list[str]
    """What was dropped, with the first line."""
    dropped: np.ndarray
    """Times at which rows were dropped, between those of their neighbours [s]."""


def read_table(log: Path, columns: str | None = None) -> LogTable:
    """Return the rows of a log that count, as far as its columns are used."""
    text = read_log(log, columns)
    found = find_columns(text.names, log)
    used = [i for places in found.places.values() for i in places]
    table, good, broken = _numbers(text, used)
    lines = np.array(text.lines)
    return _countable(log, table, lines[good], lines[broken], found, len(text.rows))


def _numbers(text: LogText, used: list[int]) -> tuple[np.ndarray, list[int], list[int]]:
    """Return the used columns, the rows that they are of, and the rows that are broken."""
    separator, width = text.separator, len(text.names)
    if separator is None or all(row.count(separator) + 1 == width for row in text.rows):
        try:  # at once, which is many times faster
            table = np.loadtxt(StringIO('\n'.join(text.rows)), delimiter=separator, ndmin=2,
                               usecols=used, quotechar='"', comments=None)
            return table, list(range(len(table))), []
        except ValueError:
            pass
    rows, good, broken = [], [], []
    for i, row in enumerate(text.rows):
        cells = cells_of(row, separator)
        try:
            if len(cells) != width:
                raise ValueError
            time, *others = (cells[column] for column in used)
            rows.append([_time(time), *map(number, others)])
            good.append(i)
        except ValueError:
            broken.append(i)
    return np.array(rows, float).reshape(-1, len(used)), good, broken


def _time(cell: str) -> float:
    """Return a time as a number; a date and time as seconds since 1970."""
    try:
        return number(cell)
    except ValueError:
        return datetime.fromisoformat(cell).timestamp()


def _countable(log: Path, table: np.ndarray, lines: np.ndarray, broken: np.ndarray,
               found: LogColumns, total: int) -> LogTable:
    """Return the rows that are numbers a robot can have, at times that increase."""
    table, found = _measured(table, found)
    remarks = list(found.remarks)
    _remark(remarks, broken, total, 'are cut off or no numbers')
    limits = np.concatenate([np.full(len(places), LARGEST[name])
                             for name, places in found.places.items()])
    with np.errstate(invalid='ignore'):
        good = (np.abs(table) <= limits).all(axis=1)
    _remark(remarks, lines[~good], total, 'hold a value that is no number or impossible')
    every = np.concatenate([broken, lines])
    table, lines = table[good], lines[good]
    t = table[:, 0]
    later = np.concatenate([[True], t[1:] > np.maximum.accumulate(t)[:-1]]) if len(t) else good[:0]
    same = np.concatenate([[False], t[1:] == t[:-1]]) if len(t) else good[:0]
    _remark(remarks, lines[~later & same], total, 'repeat the time of the row before')
    _remark(remarks, lines[~later & ~same], total, 'go back in time')
    table, lines = table[later], lines[later]
    if len(table) < 2 or len(table) < LEAST_SHARE * total:
        raise InputError(f'{log}: {len(table)} of {total} rows can be used'
                         f'{" (" + "; ".join(remarks) + ")" if remarks else ""}; at least two '
                         'whole rows, and half of all, are needed')
    values = _values(table, found)
    t = seconds_of(values.pop('time')[:, 0], values, 'time' in found.factors, remarks)
    _refuse_degrees(log, values['q'], lines)
    dropped = np.setdiff1d(every, lines)
    dropped = dropped[(dropped > lines[0]) & (dropped < lines[-1])]
    return LogTable(t, values, remarks, np.interp(dropped, lines, t))


def _measured(table: np.ndarray, found: LogColumns) -> tuple[np.ndarray, LogColumns]:
    """Return table and columns without the quantities that most rows do not have."""
    places: dict[str, list[int]] = {}
    remarks, keep, begin = list(found.remarks), list[int](), 0
    for name, columns in found.places.items():
        own = list(range(begin, begin + len(columns)))
        begin += len(columns)
        share = np.isfinite(table[:, own]).mean(axis=0) if len(table) else np.ones(1)
        if name in ('time', 'q') or share.min() > LEAST_SHARE:
            places[name], keep = columns, keep + own
        else:
            lost = int(np.argmin(share))
            remarks.append(f'column {COLUMNS[name][1].format(lost) if name in COLUMNS else name} '
                           f'has numbers in {share[lost]:.0%} of the rows: it and the others of '
                           'its six are not used')
    return table[:, keep], found._replace(places=places, remarks=remarks)


def _values(table: np.ndarray, found: LogColumns) -> dict[str, np.ndarray]:
    """Return quantity -> its columns in SI units."""
    values, begin = {}, 0
    for name, places in found.places.items():
        values[name] = table[:, begin:begin + len(places)] * found.factors.get(name, 1.0)
        begin += len(places)
    return values


def _refuse_degrees(log: Path, q: np.ndarray, lines: np.ndarray) -> None:
    """Refuse positions that no joint has: InputError by row and value."""
    far = np.abs(q[:, :MAY_TURN])
    row, joint = np.unravel_index(int(np.argmax(far)), far.shape)
    if far[row, joint] > FURTHEST:
        raise InputError(
            f'{log}: line {lines[row]}: joint {joint + 1} is at {q[row, joint]:.6g} rad, further '
            f'than any of the family turns ({FURTHEST:g} rad); if these are degrees, name the '
            'columns so, as actual_q_0 [deg], there or by --columns')


def _remark(remarks: list[str], lines: np.ndarray, total: int, why: str) -> None:
    if len(lines):
        remarks.append(f'{len(lines)} rows of {total} {why}: dropped (first: line {lines[0]})')
