"""Columns that grow batch by batch, in place: the numbers are copied once."""

from collections.abc import Sequence

import numpy as np


class Table:
    """
    Times and fields of messages, filled in any order within a batch.

    Room for ``expected`` rows is made at once; it costs memory only where it is written to.

    """

    def __init__(self, names: Sequence[str], expected: int = 0) -> None:
        self.skipped = 0
        """Rows that were opened and not filled."""
        self._count = 0
        self._capacity = max(expected, 1)
        self.stamp, self.log_time, self.publish_time = (
            np.empty(self._capacity, np.int64) for _ in range(3))
        self.fields = {name: np.empty((self._capacity, 0)) for name in names}
        self._filled = np.empty(0, bool)

    def widen(self, width: int) -> None:
        """Set the number of columns of each field; called once, before the first row is filled."""
        self.fields = {name: np.empty((self._capacity, width)) for name in self.fields}

    def open(self, log_times: np.ndarray, publish_times: np.ndarray) -> None:
        """Start a batch of rows that are to be filled."""
        self._filled = np.zeros(len(log_times), bool)
        end = self._count + len(log_times)
        if end > self._capacity:
            self._resize(max(end, 2 * self._capacity))
        self.log_time[self._count:end] = log_times
        self.publish_time[self._count:end] = publish_times

    def fill(self, chosen: np.ndarray, stamp: np.ndarray, fields: dict[str, np.ndarray]) -> None:
        """Fill rows of the batch; a field that is left out becomes NaN."""
        self._filled[chosen] = True
        rows: slice | np.ndarray = chosen + self._count
        if len(chosen) == len(self._filled):
            rows = slice(self._count, self._count + len(chosen))
        self.stamp[rows] = stamp
        for name, column in self.fields.items():
            column[rows] = fields.get(name, np.nan)

    def is_filled(self, row: int) -> bool:
        """Return whether a row of the batch is filled."""
        return bool(self._filled[row])

    def close(self) -> None:
        """End a batch; rows that were not filled are dropped."""
        number, kept = len(self._filled), int(self._filled.sum())
        if kept < number:
            begin, end = self._count, self._count + number
            for column in (self.stamp, self.log_time, self.publish_time, *self.fields.values()):
                column[begin:begin + kept] = column[begin:end][self._filled]
        self._count += kept
        self.skipped += number - kept

    def trimmed(self) -> 'Table':
        """Return the table without unused capacity."""
        if self._count < self._capacity:
            self._resize(self._count)
        return self

    def _resize(self, capacity: int) -> None:
        self._capacity = capacity
        self.stamp, self.log_time, self.publish_time = (
            _resized(column, capacity, self._count)
            for column in (self.stamp, self.log_time, self.publish_time))
        for name, column in self.fields.items():
            self.fields[name] = _resized(column, capacity, self._count)


def _resized(column: np.ndarray, capacity: int, count: int) -> np.ndarray:
    new = np.empty((capacity, *column.shape[1:]), column.dtype)
    new[:count] = column[:count]
    return new
