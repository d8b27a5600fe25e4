"""The text of a robot's log: its encoding, separator, names and rows."""

import csv
import re
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ur5_ros.analysis.data.logs.columns import (
    column_names,
    find_columns,
    is_header,
    plain_name,
)
from ur5_ros.errors import InputError
from ur5_ros.wording import number_of

#: Largest log [bytes]: ten hours at 500 Hz are about this long.
MAX_BYTES = 4 << 30

#: Lines at the beginning among which the names are looked for.
PREAMBLE = 60

SEPARATORS = (';', '\t', '|', ',')

#: How a gzip file begins, what zlib calls its form, and bytes that are decompressed at a time.
_GZIP, _GZIP_BITS, _BLOCK = b'\x1f\x8b', 31, 1 << 12

#: Marks of Unicode at the beginning, the longer ones first.
_MARKS = {b'\xff\xfe\0\0': 'utf-32', b'\0\0\xfe\xff': 'utf-32', b'\xff\xfe': 'utf-16',
          b'\xfe\xff': 'utf-16'}

_COMMENT = ('#', '%', '//')
_DECIMAL_COMMA = re.compile(r'"?\s*[-+]?\d+,\d+')
_VECTOR = re.compile(r'"?[\[(]([^\])"]*,[^\])"]*|[^\])",]* [^\])",]*)[\])]"?')


class LogText(NamedTuple):
    """The rows of a log and the names of its columns."""

    names: list[str]
    rows: list[str]
    lines: list[int]
    """Number of the line of each row, from 1."""
    separator: str | None
    """None for spaces."""
    remarks: list[str]
    """What of the file could not be read."""


def read_log(log: Path, columns: str | None) -> LogText:
    """
    Return names and rows of a log; lines before the names and comments are passed over.

    InputError if it is no such log, its columns have no names, or rows are wider than the names.

    """
    remarks: list[str] = []
    lines = _text(log, remarks).splitlines()
    at = [i for i, line in enumerate(lines) if line.strip(' #%/\t')]
    if not at:
        raise InputError(f'{log}: is empty; give a log with names and at least two whole rows')
    first, cells, separator = _beginning(lines, at)
    headed = not _is_row(cells)
    names = _names(log, cells, headed, columns)
    rows = [i for i in range(first + headed, len(lines))
            if lines[i].strip() and not lines[i].lstrip().startswith(_COMMENT)]
    body = [lines[i] for i in rows]
    if not body:
        find_columns(names, log)
        raise InputError(f'{log}: no rows under the names; at least two whole rows are needed')
    names, body, rows = _with_units(names, body, rows, separator)
    body, names = _vectors(body, names, separator)
    while len(names) > 1 and not names[-1] and _width(body[0], separator) < len(names):
        names = names[:-1]
    if separator is not None:
        body = [line.rstrip()[:-1] if line.rstrip(' ').endswith(separator)
                and _width(line, separator) > len(names) else line for line in body]
    if separator != ',' and _has_decimal_commas(body, separator):
        body = [line.replace(',', '.') for line in body]
    wide = sum(_width(line, separator) != len(names) for line in body)
    if 2 * wide > len(body) and is_header(names):
        width = number_of(_width(body[0], separator), 'column')
        raise InputError(f'{log}: the names are {len(names)}, the first row has {width}; make '
                         'them agree, or name the columns with --columns')
    return LogText(names, body, [i + 1 for i in rows], separator, remarks)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line; quotes hold together what they enclose."""
    line = line.strip('\r\n')
    if separator is not None and '"' in line:
        found = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    else:
        found = line.split(separator)
    return [cell.strip().strip('"').strip() for cell in found]


def number(cell: str) -> float:
    """Return a number whose point may be a comma, NaN for none; ValueError for another text."""
    return float(cell.replace(',', '.') or 'nan')


def _text(log: Path, remarks: list[str]) -> str:
    """Return the text of a file, decompressed as far as it goes, minus signs as ASCII has them."""
    try:
        with open(log, 'rb') as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f'{log}: no such file; give the path of a log') from None
    except OSError as error:
        raise InputError(f'{log}: cannot be read: {error.strerror}') from None
    if data.startswith(_GZIP):
        data = _decompressed(data, log, remarks)
    if len(data) > MAX_BYTES:
        raise InputError(f'{log}: more than {MAX_BYTES} bytes; split it')
    return _decoded(data, log).replace('\N{MINUS SIGN}', '-')


def _decompressed(data: bytes, log: Path, remarks: list[str]) -> bytes:
    """Return what a gzip file holds, as far as it is whole."""
    parts, size, stream = [], 0, zlib.decompressobj(wbits=_GZIP_BITS)
    at, damaged = 0, False
    while at < len(data) and size <= MAX_BYTES:
        if stream.eof:  # files behind each other are one
            if not data.startswith(_GZIP, at):
                damaged = bool(data[at:].strip(b'\0'))
                break
            stream = zlib.decompressobj(wbits=_GZIP_BITS)
        try:
            parts.append(stream.decompress(data[at:at + _BLOCK]))
        except zlib.error:
            damaged = True
            break
        size += len(parts[-1])
        at = min(at + _BLOCK, len(data)) - len(stream.unused_data)
    if not size:
        raise InputError(f'{log}: no whole gzip file; copy it again')
    if damaged or not stream.eof:
        remarks.append('the compressed file is cut or damaged; it was read as far as it goes')
    return b''.join(parts)


def _decoded(data: bytes, log: Path) -> str:
    """Return bytes as text: Unicode by its mark, else UTF-8, else the one of Windows."""
    try:
        for mark, encoding in _MARKS.items():
            if data.startswith(mark):
                return data.decode(encoding)
        if b'\0' in data[:4096]:
            raise ValueError
        try:
            return data.decode('utf-8-sig')
        except UnicodeDecodeError:  # notes in a text column: the numbers are the same
            return data.decode('cp1252')
    except ValueError:
        raise InputError(f'{log}: not a text file; give CSV in UTF-8') from None


def _beginning(lines: Sequence[str], at: Sequence[int]) -> tuple[int, list[str], str | None]:
    """Return the line of the names, else of the first row, its cells and its separator."""
    for i in at[:PREAMBLE]:
        bare = lines[i].lstrip('#%/ ')
        for separator in (*(mark for mark in SEPARATORS if mark in bare), None):
            cells = cells_of(bare, separator)
            if is_header(cells):
                return i, cells, separator
        comment = lines[i].lstrip().startswith(_COMMENT)
        separator = _separator(bare)
        cells = cells_of(bare, separator)
        if not comment and len(cells) > 6 and _is_row(cells):
            above = ((j, cells_of(lines[j].lstrip('#%/ '), separator)) for j in at if j < i)
            named = next(((j, each) for j, each in above if len(each) == len(cells)), (i, cells))
            return *named, separator
    wide = [i for i in at[:PREAMBLE] if _separator(lines[i]) and not lines[i].startswith('sep=')]
    first = wide[0] if wide else at[0]
    bare = lines[first].lstrip('#%/ ')
    return first, cells_of(bare, _separator(bare)), _separator(bare)


def _separator(line: str) -> str | None:
    found = next((mark for mark in SEPARATORS if mark in line), None)
    if found == ',' and len(line.split()) > len(line.split(',')) and _is_row(line.split()):
        return None  # the commas are those of the numbers
    return found


def _is_row(cells: Sequence[str]) -> bool:
    """Return whether most cells that are not empty are numbers."""
    filled = [cell for cell in cells if cell]
    return 2 * sum(_is_number(cell) for cell in filled) > len(filled)


def _is_number(cell: str) -> bool:
    try:
        number(cell)
    except ValueError:
        return False
    return bool(cell)


def _names(log: Path, cells: list[str], headed: bool, columns: str | None) -> list[str]:
    """Return the names of the columns: those of the file, or those that the user gives."""
    if columns is None:
        if not headed:
            raise InputError(f'{log}: {number_of(len(cells), "column")} without names; name '
                             'them, - skips one: --columns timestamp,actual_q,actual_qd,'
                             'target_moment,...')
        return cells
    names = column_names(columns)
    if len(names) != len(cells):
        raise InputError(f'{log}: --columns names {number_of(len(names), "column")}; the log '
                         f'has {len(cells)}')
    return names


def _vectors(body: list[str], names: list[str], separator: str | None,
             ) -> tuple[list[str], list[str]]:
    """Return rows and names with each vector, ``[0.1, 0.2, ...]`` in one cell, as columns."""
    if not _VECTOR.search(body[0]) or separator is None:
        return body, names
    first = _VECTOR.sub(lambda found: found[0].replace('"', '').replace(separator, ' '), body[0])
    wide = []
    for name, cell in zip(names, cells_of(first, separator), strict=False):
        inner = cell.strip('[]()').replace(',', ' ').split()
        bare, unit = plain_name(name)
        wide += [name] if len(inner) < 2 else [
            f'{bare}_{i} [{unit}]' if unit else f'{bare}_{i}' for i in range(len(inner))]
    return [_VECTOR.sub(lambda found: separator.join(found[1].replace(',', ' ').split()), line)
            for line in body], wide


def _with_units(names: list[str], body: list[str], rows: list[int], separator: str | None,
                ) -> tuple[list[str], list[str], list[int]]:
    """Return names that state the units which a row of its own under them states."""
    units = [cell.strip('[]() ') for cell in cells_of(body[0], separator)]
    if len(body) < 2 or len(units) != len(names) or any(map(_is_number, units)) or not any(units):
        return names, body, rows
    stated = [f'{name} [{unit}]' if unit and unit != '-' and not plain_name(name).unit else name
              for name, unit in zip(names, units, strict=True)]
    return stated, body[1:], rows[1:]


def _width(line: str, separator: str | None) -> int:
    if separator is None or '"' in line:
        return len(cells_of(line, separator))
    return line.count(separator) + 1


def _has_decimal_commas(body: Sequence[str], separator: str | None) -> bool:
    """Return whether a number of the first rows has a comma for its point."""
    return any(_DECIMAL_COMMA.match(cell) for line in body[:20]
               for cell in cells_of(line, separator))
