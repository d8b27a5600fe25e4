"""Fixed layouts of CDR messages: constant bytes, and the offsets of the numbers."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

#: Encapsulation header of little-endian plain CDR; its last two bytes are options, ignored.
LITTLE_ENDIAN = b'\x00\x01\x00\x00'


class Layout:
    """
    The bytes that all messages of one fixed layout share, and the slots where they differ.

    Padding is written as zeros and ignored when read: other writers leave it uninitialised.
    Alignment counts from the end of the encapsulation header (OMG CDR, DDS-XTypes 7.4.1).

    """

    def __init__(self) -> None:
        self.template = bytearray(LITTLE_ENDIAN)
        self.mask = bytearray(b'\xff\xff\x00\x00')
        self.slots: dict[str, tuple[int, str, int]] = {}
        """Name -> (offset, numpy type of one number, count), without those of no number."""
        self._edges: list[tuple[int, int]] = []

    def align(self, size: int) -> None:
        """Pad with zeros up to a multiple of ``size``."""
        padding = bytes(-(len(self.template) - 4) % size)
        self.template += padding
        self.mask += padding

    def count(self, number: int) -> None:
        """Append the length of a sequence."""
        self.align(4)
        self.constant(number.to_bytes(4, 'little'))

    def constant(self, data: bytes) -> None:
        """Append bytes that every message has."""
        self.template += data
        self.mask += b'\xff' * len(data)

    def text(self, text: str) -> None:
        """Append a string, with its length and the closing zero."""
        data = text.encode() + b'\0'
        self.count(len(data))
        self.constant(data)

    def texts(self, texts: Sequence[str]) -> None:
        """Append a sequence of strings."""
        self.count(len(texts))
        for text in texts:
            self.text(text)

    def slot(self, name: str, kind: str, number: int) -> None:
        """Append ``number`` values of numpy type ``kind`` that differ between messages."""
        width = np.dtype(kind).itemsize
        if number:
            self.align(width)
            self.slots[name] = (len(self.template), kind, number)
        self._edges.append((len(self.template), len(self.template) + width * number))
        self.template += bytes(width * number)
        self.mask += bytes(width * number)

    def doubles(self, name: str, number: int) -> None:
        """Append a sequence of ``number`` float64 values."""
        self.count(number)
        self.slot(name, '<f8', number)

    def close(self) -> 'Layout':
        """Prepare for encoding and comparing; nothing is appended afterwards."""
        self.size = len(self.template)
        self._mask = int.from_bytes(self.mask, 'little')
        self._expected = int.from_bytes(self.template, 'little') & self._mask
        self._parts: list[bytes] = []
        self._constants = []
        at = 0
        for begin, end in [*self._edges, (self.size, self.size)]:
            self._parts += [bytes(self.template[at:begin]), b'']
            if begin > at:
                self._constants.append((slice(at, begin), bytes(self.template[at:begin])))
            at = end
        self._parts.pop()
        return self

    def fill(self, *slots: bytes) -> bytes:
        """Return a message: the template with the contents of all slots, in their order."""
        parts = self._parts.copy()
        parts[1::2] = slots
        return b''.join(parts)

    def matches(self, data: bytes) -> bool:
        """Return whether ``data`` has this layout: same size, same names, same lengths."""
        if len(data) != self.size:
            return False
        for place, expected in self._constants:  # our own messages: padding is zero
            if data[place] != expected:
                return int.from_bytes(data, 'little') & self._mask == self._expected
        return True

    def fits(self, rows: np.ndarray) -> np.ndarray:
        """Return which messages, uint8 of shape (n, size), have this layout, shape (n,)."""
        found = np.ones(len(rows), bool)
        whole = self.size // 8 * 8
        pieces = [(at, '<u8') for at in range(0, whole, 8)]
        pieces += [(at, 'u1') for at in range(whole, self.size)]
        runs = groupby(pieces, key=lambda piece: (
            piece[1], any(self.mask[piece[0]:piece[0] + np.dtype(piece[1]).itemsize])))
        for (kind, compared), run in runs:
            offsets = [at for at, _ in run]
            if not compared:
                continue
            width = np.dtype(kind).itemsize
            words = np.ndarray((len(rows), len(offsets)), kind, rows, offsets[0],
                               (self.size, width))
            mask = np.frombuffer(self.mask, kind, len(offsets), offsets[0])
            expected = np.frombuffer(self.template, kind, len(offsets), offsets[0]) & mask
            equal = (words & mask) == expected
            if not equal.all():  # over all at once: much faster than row by row
                found &= equal.all(axis=1)
        return found
