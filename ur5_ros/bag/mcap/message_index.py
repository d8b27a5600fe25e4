"""Offsets of the messages of a chunk, indexed in Python or, for much data, by compiled code."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from ur5_ros.bag.mcap.records import FRAME, MESSAGE, MESSAGE_EXTRA, Opcode


class MessageIndex(NamedTuple):
    """The messages and definitions in a buffer of whole records."""

    channels: np.ndarray
    """Channel of each message, int64."""
    offsets: np.ndarray
    """Offset of the data of each message, int64."""
    lengths: np.ndarray
    """Bytes of data of each message, int64."""
    log_times: np.ndarray
    """[ns], int64; a time beyond its range wraps round."""
    publish_times: np.ndarray
    """[ns], int64."""
    definitions: list[tuple[int, int, int]]
    """Schema and channel records: (opcode, start, end of the content)."""


#: :func:`index_messages`, or :class:`CompiledMessageIndex`.
Indexer = Callable[[bytes], MessageIndex | None]


def index_messages(content: bytes | bytearray) -> MessageIndex | None:
    """Return the index of a chunk's content, None if it is not whole message and definition
    records.
    """
    rows: list[tuple[int, int, int, int, int]] = []
    tables: list[np.ndarray] = []
    definitions = []
    at, end = 0, len(content)
    frame, message = FRAME.unpack_from, MESSAGE.unpack_from
    while at + FRAME.size <= end:
        opcode, length = frame(content, at)
        after = at + FRAME.size + length
        if after > end:
            return None
        if opcode == 5 and length >= MESSAGE_EXTRA:
            _, _, channel, _, log_time, publish_time = message(content, at)
            rows.append((channel, at + MESSAGE.size, length - MESSAGE_EXTRA,
                         log_time, publish_time))
            if len(rows) == _ROWS:
                tables.append(_table(rows))
                rows.clear()
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            definitions.append((opcode, at + FRAME.size, after))
        else:
            return None
        at = after
    if at != end:
        return None
    return _from_table(np.concatenate([*tables, _table(rows)], axis=1), definitions)


#: Rows that are kept as Python numbers, which take ten times the memory of an array.
_ROWS = 20_000


def _table(rows: list[tuple[int, int, int, int, int]]) -> np.ndarray:
    return np.array(rows, np.uint64).reshape(-1, 5).T.astype(np.int64)


def _from_table(table: np.ndarray, definitions: list[tuple[int, int, int]]) -> MessageIndex:
    return MessageIndex(table[0], table[1], table[2], table[3], table[4], definitions)


@cache
def _compiled() -> Callable:
    """Return the compiled indexer; numba is loaded and run only for large files."""
    from numba import njit

    def number(buffer, at, size):
        value = np.int64(0)
        for k in range(size):
            value |= np.int64(buffer[at + k]) << (8 * k)
        return value

    def steps(buffer, table, definitions):
        at, end, messages, found = 0, len(buffer), 0, 0
        while at + 9 <= end:
            length = number(buffer, at + 1, 8)
            if length < 0 or length > end - at - 9:
                return -1, found
            if buffer[at] == 5 and length >= 22:
                table[0, messages] = number(buffer, at + 9, 2)
                table[1, messages] = at + 31
                table[2, messages] = length - 22
                table[3, messages] = number(buffer, at + 15, 8)
                table[4, messages] = number(buffer, at + 23, 8)
                messages += 1
            elif buffer[at] == 3 or buffer[at] == 4:
                if found < len(definitions):
                    definitions[found, 0] = buffer[at]
                    definitions[found, 1] = at + 9
                    definitions[found, 2] = at + 9 + length
                found += 1
            else:
                return -1, found
            at += 9 + length
        return (messages if at == end else -1), found

    try:
        number = njit(cache=True, nogil=True)(number)
        return njit(cache=True, nogil=True)(steps)
    except RuntimeError:  # no folder for numba's cache
        number = njit(nogil=True)(number)
        return njit(nogil=True)(steps)


class CompiledMessageIndex:
    """:func:`index_messages` compiled: some fifty times faster, half a second to compile."""

    #: More schemas and channels than this in one buffer are indexed in Python.
    MAX_DEFINITIONS = 1000

    def __init__(self) -> None:
        self._steps = _compiled()
        self._table = np.empty((5, 0), np.int64)
        self._definitions = np.empty((self.MAX_DEFINITIONS, 3), np.int64)

    def __call__(self, content: bytes | bytearray) -> MessageIndex | None:
        """Return what :func:`index_messages` returns."""
        if self._table.shape[1] < len(content) // MESSAGE.size:
            self._table = np.empty((5, len(content) // MESSAGE.size), np.int64)
        buffer = np.frombuffer(content, np.uint8)
        messages, found = self._steps(buffer, self._table, self._definitions)
        if messages < 0:
            return None
        if found > self.MAX_DEFINITIONS:
            return index_messages(content)
        definitions = [(opcode, begin, end) for opcode, begin, end
                       in self._definitions[:found].tolist()]
        return _from_table(self._table[:, :messages].copy(), definitions)
