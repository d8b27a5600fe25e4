"""Messages collected into arrays: all of one layout at once, not decoded one by one."""

from collections.abc import Callable, Sequence

import numpy as np

from ur5_ros.bag.arrays.columns import COLUMN_TYPES, Columns, RawColumns
from ur5_ros.bag.arrays.table import Table
from ur5_ros.bag.mcap.message_index import MessageIndex
from ur5_ros.cdr.codec import Definitions, decode
from ur5_ros.cdr.layout import Layout
from ur5_ros.errors import BagError
from ur5_ros.wording import number_of

#: Layouts of one topic that are read as arrays; messages of further ones are decoded one by one.
MAX_LAYOUTS = 32

_NANOSECONDS = 1_000_000_000


def cut_out(buffer: bytes | bytearray, offsets: np.ndarray, length: int) -> np.ndarray:
    """Return pieces of equal length out of a buffer, shape (len(offsets), length), uint8."""
    if length == 0 or len(offsets) == 0:
        return np.empty((len(offsets), length), np.uint8)
    windows = np.ndarray((len(buffer) - length + 1,), f'V{length}', buffer, strides=(1,))
    return windows[offsets].view(np.uint8).reshape(-1, length)


class RawCollector:
    """Collects the messages of one topic as bytes."""

    def __init__(self) -> None:
        self._times: list[np.ndarray] = []
        self._lengths: list[np.ndarray] = []
        self._data: list[np.ndarray] = []

    def add(self, buffer: bytes | bytearray, found: MessageIndex) -> None:
        """Add the messages of a buffer."""
        self._times.append(np.stack([found.log_times, found.publish_times]))
        self._lengths.append(found.lengths)
        lengths = np.unique(found.lengths)
        if len(lengths) == 1:
            self._data.append(cut_out(buffer, found.offsets, int(lengths[0])).reshape(-1))
        else:
            self._data.append(np.frombuffer(b''.join(
                buffer[begin:begin + length] for begin, length
                in zip(found.offsets.tolist(), found.lengths.tolist(), strict=True)), np.uint8))

    def result(self) -> RawColumns:
        """Return all that was added, in its order."""
        times = np.concatenate([np.empty((2, 0), np.int64), *self._times], axis=1)
        lengths = np.concatenate([np.zeros(1, np.int64), *self._lengths])
        data = np.concatenate([np.empty(0, np.uint8), *self._data])
        return RawColumns(times[0], times[1], data, np.cumsum(lengths))


class Collector:
    """
    Collects the numbers of one topic, of a type of COLUMN_TYPES.

    ``names`` are the columns in their order, by default those of the first message; ``report``
    takes a sentence about messages that could not be read; ``expected`` is the number of messages
    to make room for.

    """

    def __init__(self, topic: str, type_name: str, definitions: Definitions,
                 names: Sequence[str] | None, report: Callable[[str], None],
                 expected: int = 0) -> None:
        self._topic = topic
        self._type = type_name
        self._kind = COLUMN_TYPES[type_name]
        self._definitions = definitions
        self._names: tuple[str, ...] | None = None
        self._table = Table(self._kind.fields, expected)
        if names is not None:
            self._name(names)
        self._report = report
        self._layouts: list[tuple[Layout, list[int] | None]] = []
        self._unread = 0
        self._first_unread = ''
        self._broken: list[int] = []
        self._short: dict[str, int] = {}

    def _name(self, names: Sequence[str]) -> None:
        """Set the names of the columns."""
        self._names = tuple(names)
        self._table.widen(len(self._names))

    def add(self, buffer: bytes | bytearray, found: MessageIndex) -> None:
        """Add the messages of a buffer."""
        self._table.open(found.log_times, found.publish_times)
        left = np.ones(len(found.offsets), bool)
        for known in self._layouts:
            self._take(known, buffer, found, left)
        while left.any():
            first = int(left.argmax())
            begin = int(found.offsets[first])
            new = self._read(bytes(buffer[begin:begin + int(found.lengths[first])]), first)
            if new is not None:
                self._layouts.append(new)
                self._take(new, buffer, found, left)
            elif not self._table.is_filled(first):
                self._broken.append(int(found.log_times[first]))
            left[first] = False
        self._table.close()

    def _take(self, known: tuple[Layout, list[int] | None], buffer: bytes | bytearray,
              found: MessageIndex, left: np.ndarray) -> None:
        """Read all messages of one layout at once."""
        layout, order = known
        chosen = np.flatnonzero(left & (found.lengths == layout.size))
        data = cut_out(buffer, found.offsets[chosen], layout.size)
        fits = layout.fits(data)
        if not fits.all():
            chosen, data = chosen[fits], data[fits]
        left[chosen] = False
        if order is None:
            return
        seconds, nanoseconds = (data[:, at:at + 4].view(kind)[:, 0] for at, kind
                                in ((4, '<i4'), (8, '<u4')))
        fields = {}
        for name in self._kind.fields:
            if name in layout.slots:
                offset, kind, number = layout.slots[name]
                values = data[:, offset:offset + 8 * number].view(kind)
                fields[name] = values if order == list(range(number)) else values[:, order]
        self._table.fill(chosen, seconds.astype(np.int64) * _NANOSECONDS + nanoseconds, fields)

    def _read(self, data: bytes, at: int) -> tuple[Layout, list[int] | None] | None:
        """Decode one message into its row; return its layout where others may share it."""
        try:
            message = decode(self._type, data, self._definitions)
        except BagError as problem:
            self._unread += 1
            self._first_unread = self._first_unread or str(problem)
            return None
        names = list(self._kind.names(message))
        values = self._kind.values(message)
        filled = [field for field in self._kind.fields if len(values.get(field, ()))]
        whole = all(len(values[field]) == len(names) for field in filled)
        if not values or not names or len(set(names)) != len(names) or (
                self._names is None and not whole):
            return None
        if self._names is None:
            self._name(names)
        order = [names.index(name) for name in self._names or ()] \
            if set(self._names or ()) <= set(names) else None
        if not whole and order is not None:
            short = [field for field in filled if len(values[field]) <= max(order)]
            filled = [field for field in filled if field not in short]
            if self._kind.fields[0] not in filled:
                return None
            for field in short:
                self._short[field] = self._short.get(field, 0) + 1
        if whole and len(self._layouts) < MAX_LAYOUTS:
            layout = self._kind.layout(names, message['header']['frame_id'], filled)
            if layout.matches(data):
                return layout, order
        if order is not None:
            time = message['header']['stamp']
            self._table.fill(
                np.array([at]), np.array([time['sec'] * _NANOSECONDS + time['nanosec']]),
                {field: np.asarray(values[field], float)[None, order] for field in filled})
        return None

    def result(self) -> Columns:
        """Return all that was added, in its order."""
        if self._unread:
            self._report(f'topic {self._topic}: {number_of(self._unread, "message")} could not be '
                         f'read; the first: {self._first_unread}')
        table = self._table.trimmed()
        return Columns(self._names or (), table.stamp, table.log_time, table.publish_time,
                       table.fields, table.skipped, np.array(self._broken, np.int64),
                       self._short)
