"""A robot's log as text: separator, names, and the rows that count."""

import gzip
import re
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.logs.columns import LARGEST, column_names, find_columns
from ur5_ros.errors import InputError

#: Largest log [bytes]: ten hours at 500 Hz are about this long.
MAX_BYTES = 4 << 30

#: Share of the rows that must count.
LEAST_SHARE = 0.5

_DECIMAL_COMMA = re.compile(r'"?\s*[-+]?\d+,\d+')


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
    """
    Return the rows of a log that count, as far as its columns are used.

    Parameters
    ----------
    log : pathlib.Path
        CSV, separated by commas, semicolons, tabs or spaces, maybe gzipped.
    columns : str, optional
        Names of the columns in the order of the file, for one without names.

    Raises
    ------
    InputError
        If it is no such log, lacks columns, or most of its rows do not count.

    """
    lines = _text(log).splitlines()
    first = next((i for i, line in enumerate(lines) if line.strip(' #\t')), None)
    if first is None:
        raise InputError(f'{log}: is empty; give a log with names and at least two whole rows')
    separator = next((mark for mark in (';', '\t', ',') if mark in lines[first]), None)
    if separator == ',' and _is_number(lines[first].split()[0]) and ' ' in lines[first].strip():
        separator = None if len(lines[first].split()) > len(lines[first].split(',')) else ','
    cells = _cells(lines[first].lstrip('# '), separator)
    headed = not _is_number(cells[0])
    body, skipped = lines[first + headed:], first + headed
    names = _names(log, cells, headed, columns)
    found = find_columns(names, log)
    if not any(line.strip() for line in body):
        raise InputError(f'{log}: no rows under the names; at least two whole rows are needed')
    used = [i for places in found.values() for i in places]
    if separator != ',' and _has_decimal_commas(body, separator):
        body = [line.replace(',', '.') for line in body]
    table, line_numbers, broken = _numbers(body, separator, used, len(names))
    return _countable(log, table, line_numbers + skipped + 1, broken + skipped + 1, found,
                      sum(bool(line.strip()) for line in body))


def _names(log: Path, cells: list[str], headed: bool, columns: str | None) -> list[str]:
    """Return the names of the columns: those of the file, or those that the user gives."""
    if columns is None:
        if not headed:
            raise InputError(f'{log}: its {len(cells)} columns have no names; name them, - skips '
                             'one: --columns timestamp,actual_q,actual_qd,target_moment,...')
        return cells
    names = column_names(columns)
    if len(names) != len(cells):
        raise InputError(f'{log}: --columns names {len(names)} columns; the log has {len(cells)}')
    return names


def _text(log: Path) -> str:
    try:
        with open(log, 'rb') as plain:
            zipped = plain.read(2) == b'\x1f\x8b'
        with (gzip.open if zipped else open)(log, 'rb') as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, EOFError) as error:
        raise InputError(f'{log}: cannot be read: {getattr(error, "strerror", None) or error}'
                         ) from None
    if len(data) > MAX_BYTES:
        raise InputError(f'{log}: more than {MAX_BYTES} bytes; split it')
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError:
        raise InputError(f'{log}: not a text file; give CSV in UTF-8') from None


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip('"') for cell in line.strip('\r\n').split(separator)]


def _has_decimal_commas(body: list[str], separator: str | None) -> bool:
    """Return whether a number of the first rows has a comma for its point."""
    first = [line for line in body[:20] if line.strip()]
    return any(_DECIMAL_COMMA.match(cell) for line in first for cell in _cells(line, separator))


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(',', '.'))
    except ValueError:
        return False
    return True


def _numbers(
    body: list[str], separator: str | None, used: list[int], width: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the used columns, the lines that they are of, and the lines that are broken."""
    at = np.array([i for i, line in enumerate(body) if line.strip()])
    text = '\n'.join(body[i] for i in at)
    widths = np.array([width if separator is None else body[i].count(separator) + 1 for i in at])
    if (widths == width).all():
        try:  # at once, which is many times faster
            table = np.loadtxt(StringIO(text), delimiter=separator, ndmin=2, usecols=used,
                               quotechar='"', comments=None)
            return table, at, np.zeros(0, dtype=int)
        except ValueError:
            pass
    rows, good, broken = [], [], []
    for i in at.tolist():
        cells = _cells(body[i], separator)
        try:
            if len(cells) != width:
                raise ValueError
            rows.append([float(cells[column]) for column in used])
            good.append(i)
        except ValueError:
            broken.append(i)
    return (np.array(rows, float).reshape(-1, len(used)), np.array(good, dtype=int),
            np.array(broken, dtype=int))


def _countable(log: Path, table: np.ndarray, lines: np.ndarray, broken: np.ndarray,
               found: dict[str, list[int]], total: int) -> LogTable:
    """Return the rows that are numbers a robot can have, at times that increase."""
    remarks: list[str] = []
    _remark(remarks, broken, total, 'are cut off or no numbers')
    limits = np.concatenate([np.full(len(places), LARGEST[name])
                             for name, places in found.items()])
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
    values, begin = {}, 0
    for name, places in found.items():
        values[name] = table[:, begin:begin + len(places)]
        begin += len(places)
    t = values.pop('time')[:, 0]
    dropped = np.setdiff1d(every, lines)
    dropped = dropped[(dropped > lines[0]) & (dropped < lines[-1])]
    return LogTable(t, values, remarks, np.interp(dropped, lines, t))


def _remark(remarks: list[str], lines: np.ndarray, total: int, why: str) -> None:
    if len(lines):
        remarks.append(f'{len(lines)} rows of {total} {why}: dropped (first: line {lines[0]})')
