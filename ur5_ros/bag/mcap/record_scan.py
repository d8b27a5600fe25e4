"""The records of an MCAP file, one after the other; each length is checked before it is used."""

import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from struct import error as StructError

import numpy as np

from ur5_ros.bag.mcap.records import FRAME, MAGIC, MAX_RECORD, Opcode
from ur5_ros.errors import BagError

#: Bytes that are read at once; a file that is no larger is read once only.
READ_SIZE = 16 << 20

Buffer = bytes | memoryview

_DATA_END = FRAME.pack(Opcode.DATA_END, 4)


@contextmanager
def opened(path: Path) -> Iterator[BufferedReader]:
    """Open a bag's file to read it; BagError where that fails, then or within."""
    if path.exists() and not path.is_file():
        raise BagError(f'{path}: no file')  # a pipe would be waited for
    try:
        with open(path, 'rb') as file:
            yield file
    except OSError as error:
        raise BagError(f'{path}: cannot be read: {error.strerror}') from None


def read_block(file: BufferedReader, size: int, before: Buffer = b'') -> memoryview:
    """
    Return the next bytes of a file, at most ``size``, behind those of ``before``.

    numpy asks for large pages, which makes fresh memory several times cheaper than that of bytes.
    """
    block = np.empty(len(before) + size, np.uint8)
    if before:
        block[:len(before)] = np.frombuffer(before, np.uint8)
    return block.data[:len(before) + file.readinto(block[len(before):].data)]


def scan(path: Path, size: int, report: Callable[[str], None],
         start: Buffer = b'') -> Iterator[tuple[int, memoryview]]:
    """
    Yield (opcode, whole record) of the data section, its end included, up to the first damage.

    ``size`` is that of the file when it was opened [bytes]: what was appended later is not read.
    ``start`` are the first bytes, if they have been read already.

    """
    try:
        with open(path, 'rb') as file:
            window = start or read_block(file, READ_SIZE)
            file.seek(len(window))
            at = begin = len(MAGIC)
            while at < size:
                if len(window) - begin < FRAME.size:
                    window, begin = read_block(file, READ_SIZE, window[begin:]), 0
                left = size - at - FRAME.size
                opcode, length = FRAME.unpack_from(window, begin) if left >= 0 else (0, 1)
                if length > left or (opcode == Opcode.DATA_END and length != 4):
                    report(f'{path}: is cut off or damaged in the record at byte {at}; '
                           'the rest was left out')
                    return
                if opcode == 0 or length > MAX_RECORD + 100:
                    report(f'{path}: the record at byte {at} claims kind {opcode:#04x} '
                           f'and {length} bytes; the rest was left out')
                    return
                end = begin + FRAME.size + length
                if end > len(window):
                    window = read_block(file, max(READ_SIZE, end - len(window)), window[begin:])
                    begin, end = 0, end - begin
                yield opcode, memoryview(window[begin:end])
                at += end - begin
                begin = end
                if opcode == Opcode.DATA_END:
                    return
    except (OSError, StructError) as error:  # deleted, or shortened while it was read
        report(f'{path}: cannot be read on: {error}')


def read_chunks(path: Path, chunks: list[tuple[int, int]],
                report: Callable[[str], None]) -> Iterator[tuple[int, memoryview]]:
    """Yield (opcode, whole record) of chunks at known (offset, length) [bytes]."""
    try:
        with open(path, 'rb') as file:
            for offset, length in chunks:
                file.seek(offset)
                record = file.read(min(length, MAX_RECORD + 100))
                if record[:FRAME.size] != FRAME.pack(Opcode.CHUNK, length - FRAME.size):
                    report(f'{path}: the chunk at byte {offset} is damaged; it was left out')
                else:
                    yield Opcode.CHUNK, memoryview(record)
    except (OSError, StructError) as error:
        report(f'{path}: cannot be read on: {error}')


def data_crc(path: Path, end: int) -> tuple[int, int, Buffer] | None:
    """
    Return the CRC that a file states for its data, the one found, and the first bytes read.

    ``end`` is the offset of the summary, right after the record that ends the data; None where
    the data do not end there.

    """
    with open(path, 'rb') as file:
        data = start = read_block(file, READ_SIZE)
        crc, left = 0, end - len(_DATA_END) - 4
        while left > 0 and data:
            crc = zlib.crc32(memoryview(data)[:left], crc)
            left -= len(data)
            data = read_block(file, min(READ_SIZE, max(left, 0)))
        file.seek(end - len(_DATA_END) - 4)
        record = file.read(len(_DATA_END) + 4)
    if left > 0 or not record.startswith(_DATA_END) or len(record) < len(_DATA_END) + 4:
        return None
    return int.from_bytes(record[-4:], 'little'), crc, start
