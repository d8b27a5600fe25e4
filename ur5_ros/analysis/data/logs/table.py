"""The rows of a robot's log that count, as numbers in SI units."""

from datetime import datetime
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.logs.columns import COLUMNS, LARGEST, LogColumns, find_columns
from ur5_ros.analysis.data.logs.text import LogText, cells_of, number, read_log
from ur5_ros.analysis.data.logs.time_order import time_order
from ur5_ros.analysis.data.logs.time_unit import seconds_of
from ur5_ros.errors import InputError
from ur5_ros.wording import agree, number_of

#: Share of the rows that must count.
LEAST_SHARE = 0.5

#: A joint turns no further than this [rad]; wrist 3 of some arms does.
FURTHEST, MAY_TURN = 13.0, 5

#: Share of the rows up to which such angles are glitches, not another unit.
GLITCH_SHARE = 0.02


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
    found = found._replace(remarks=[*text.remarks, *found.remarks])
    used = [i for places in found.places.values() for i in places]
    table, good, broken = _numbers(text, used)
    table, found = _time_as_one(table, found)
    lines = np.array(text.lines)
    places = np.array([row for row, _ in broken], dtype=int)
    return _countable(log, table, lines[good], lines[places], broken[0][1] if broken else '',
                      found, len(text.rows))


def _numbers(text: LogText, used: list[int],
             ) -> tuple[np.ndarray, list[int], list[tuple[int, str]]]:
    """Return the used columns, the rows that they are of, and the broken rows with the reason."""
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
        values, reason = _parsed(cells_of(row, separator), used, text.names)
        if reason:
            broken.append((i, reason))
        else:
            rows.append(values)
            good.append(i)
    return np.array(rows, float).reshape(-1, len(used)), good, broken


def _parsed(cells: list[str], used: list[int], names: list[str]) -> tuple[list[float], str]:
    """Return the numbers of a row, the time first; and why it is broken, empty where it is not."""
    if len(cells) != len(names):
        return [], f'{number_of(len(cells), "cell")} instead of {len(names)}'
    values: list[float] = []
    for column in used:
        try:
            values.append(number(cells[column]) if values else _time(cells[column]))
        except ValueError:
            return [], f'{names[column].strip()} = {cells[column][:30]!r}'
    return values, ''


def _time(cell: str) -> float:
    """Return a time as a number; a date and time as seconds since 1970."""
    try:
        return number(cell)
    except ValueError:
        return datetime.fromisoformat(cell).timestamp()


def _time_as_one(table: np.ndarray, found: LogColumns) -> tuple[np.ndarray, LogColumns]:
    """Return table and columns with seconds and nanoseconds of the time added."""
    if len(found.places['time']) == 1:
        return table, found
    table = np.column_stack([table[:, 0] + 1e-9 * table[:, 1], table[:, 2:]])
    return table, found._replace(places={**found.places, 'time': found.places['time'][:1]},
                                 factors={**found.factors, 'time': 1.0})


def _countable(log: Path, table: np.ndarray, lines: np.ndarray, broken: np.ndarray, reason: str,
               found: LogColumns, total: int) -> LogTable:
    """Return the rows that are numbers a robot can have, at times that increase."""
    table, found = _measured(table, found)
    remarks = list(found.remarks)
    _remark(remarks, broken, total, 'are cut off or no numbers', reason)
    limits = np.concatenate([np.full(len(places), LARGEST[name])
                             for name, places in found.places.items()])
    with np.errstate(invalid='ignore'):
        good = (np.abs(table) <= limits).all(axis=1)
    _remark(remarks, lines[~good], total, 'hold a value that is no number or impossible')
    every = np.concatenate([broken, lines])
    table, lines = table[good], lines[good]
    found_order = time_order(table[:, 0])
    if found_order.turned:
        remarks.append('the rows run backwards in time; they were turned round')
    _remark(remarks, lines[found_order.repeated], total, 'repeat the time of the row before')
    _remark(remarks, lines[found_order.stray], total, 'go back in time, or ahead of it')
    others = lines[found_order.others]
    _remark(remarks, others, total, 'are of another recording in the same file')
    table, lines = table[found_order.order], lines[found_order.order]
    alone = total - len(others) - int(found_order.repeated.sum())
    if len(table) < 2 or len(table) < LEAST_SHARE * alone:
        raise InputError(f'{log}: {len(table)} of {total} rows can be used'
                         f'{" (" + "; ".join(remarks) + ")" if remarks else ""}; at least two '
                         'whole rows, and half of all, are needed')
    values = _values(table, found)
    far = _beyond_turning(log, values['q'], lines)
    _remark(remarks, lines[far], total, 'hold an angle further than any joint turns')
    values, lines = {name: each[~far] for name, each in values.items()}, lines[~far]
    t = seconds_of(values.pop('time')[:, 0], values, 'time' in found.factors, remarks)
    dropped = np.setdiff1d(every, np.concatenate([lines, others]))
    dropped = dropped[(dropped > lines.min()) & (dropped < lines.max())]
    ascending = np.argsort(lines)
    return LogTable(t, values, remarks, np.interp(dropped, lines[ascending], t[ascending]))


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
            which, others = ((COLUMNS[name][1].format(lost), 'it and the others of its six are')
                             if name in COLUMNS else (name, 'it is'))
            remarks.append(f'column {which} has numbers in {share[lost]:.0%} of the rows: '
                           f'{others} not used')
    return table[:, keep], found._replace(places=places, remarks=remarks)


def _values(table: np.ndarray, found: LogColumns) -> dict[str, np.ndarray]:
    """Return quantity -> its columns in SI units."""
    values, begin = {}, 0
    for name, places in found.places.items():
        values[name] = table[:, begin:begin + len(places)] * found.factors.get(name, 1.0)
        begin += len(places)
    return values


def _beyond_turning(log: Path, q: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Return the few rows with positions that no joint has; InputError for many: other units."""
    far = np.abs(q[:, :MAY_TURN])
    beyond = (far > FURTHEST).any(axis=1)
    if beyond.mean() > GLITCH_SHARE or len(q) - beyond.sum() < 2:
        row, joint = np.unravel_index(int(np.argmax(far)), far.shape)
        raise InputError(
            f'{log}: line {lines[row]}: joint {joint + 1} is at {q[row, joint]:.6g} rad, further '
            f'than any of the family turns ({FURTHEST:g} rad), and so are {beyond.sum()} rows of '
            f'{len(q)}; if these are degrees, name the columns so, as actual_q_0 [deg], there or '
            'by --columns')
    return beyond


def _remark(remarks: list[str], lines: np.ndarray, total: int, why: str,
            reason: str = '') -> None:
    if len(lines):
        first = f'line {lines[0]}{": " if reason else ""}{reason}'
        remarks.append(f'{number_of(len(lines), "row", total)} {agree(len(lines), why)}: dropped '
                       f'(first: {first})')
