"""Chunks of an MCAP file: messages packed and compressed, unpacked within bounds."""

import zlib
from collections.abc import Iterator, Sequence
from itertools import repeat
from struct import Struct
from typing import NamedTuple

import lz4.frame
import numpy as np
import zstandard

from ur5_ros.bag.mcap.records import (
    FRAME,
    INDEX_ENTRY,
    MAX_RECORD,
    MESSAGE,
    MESSAGE_EXTRA,
    Opcode,
)
from ur5_ros.errors import BagError

#: Size at which a chunk is closed [bytes before compression]: one LZ4 block.
CHUNK_SIZE = 64 << 10

#: Largest message that is written [bytes]: its chunk can still be read.
MAX_MESSAGE = MAX_RECORD // 2

#: (channel, log time [ns], publish time [ns], data)
Message = tuple[int, int, int, bytes]

_CHUNK_HEAD = Struct('<QQQI')
_INDEX_HEAD = Struct('<BQHI')


class PackedChunk(NamedTuple):
    """A chunk as it is written, and the content of its chunk index."""

    record: bytes
    indexes: dict[int, bytes]
    """Message index record of each channel."""
    counts: dict[int, int]
    """Messages of each channel."""
    start: int
    """Smallest log time [ns]."""
    end: int
    """Largest log time [ns]."""
    compressed_size: int
    uncompressed_size: int


def cut(messages: Sequence[Message], size: int = CHUNK_SIZE) -> Iterator[Sequence[Message]]:
    """Yield runs of messages of at most ``size`` bytes, or of one message that is larger."""
    ends = np.cumsum([len(message[3]) + MESSAGE.size for message in messages])
    begin = used = 0
    while begin < len(messages):
        end = max(begin + 1, int(np.searchsorted(ends, used + size, 'right')))
        if ends[begin] - used > MAX_MESSAGE:
            raise OverflowError(f'a message of {ends[begin] - used} bytes; at most {MAX_MESSAGE} '
                                'are written')
        yield messages[begin:end]
        begin, used = end, int(ends[end - 1])


def pack_chunk(definitions: bytes, messages: Sequence[Message]) -> PackedChunk:
    """Return messages as an LZ4 chunk with CRC, and their index."""
    channels, log_times, publish_times, data = zip(*messages, strict=True)
    lengths = list(map(len, data))
    parts = [b''] * (2 * len(data))
    parts[0::2] = map(MESSAGE.pack, repeat(Opcode.MESSAGE.value),
                      [length + MESSAGE_EXTRA for length in lengths],
                      channels, repeat(0), log_times, publish_times)
    parts[1::2] = data
    content = definitions + b''.join(parts)

    compressed = lz4.frame.compress(content)
    start, end = min(log_times), max(log_times)
    head = _CHUNK_HEAD.pack(start, end, len(content), zlib.crc32(content)) \
        + b'\x03\0\0\0lz4' + len(compressed).to_bytes(8, 'little')
    record = FRAME.pack(Opcode.CHUNK, len(head) + len(compressed)) + head + compressed

    entries = np.empty(len(data), INDEX_ENTRY)
    entries['log_time'] = log_times
    ends = np.cumsum(np.array(lengths, np.uint64) + MESSAGE.size)
    entries['offset'][0] = len(definitions)
    entries['offset'][1:] = ends[:-1] + len(definitions)
    of_channel = np.array(channels)
    indexes, counts = {}, {}
    for channel in sorted(set(channels)):
        listed = entries[of_channel == channel]
        counts[channel] = len(listed)
        indexes[channel] = _INDEX_HEAD.pack(
            Opcode.MESSAGE_INDEX, 6 + listed.nbytes, channel, listed.nbytes) + listed.tobytes()
    return PackedChunk(record, indexes, counts, start, end, len(compressed), len(content))


def decompress(compression: str, data: memoryview, size: int, source: str) -> bytes:
    """
    Return the content of a chunk, never allocating more than it states and than is allowed.

    ``compression``: ``''``, ``'lz4'`` or ``'zstd'``.
    """
    try:
        if compression == 'lz4':
            content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        elif compression == 'zstd':
            decompressor = zstandard.ZstdDecompressor(max_window_size=MAX_RECORD)
            content = decompressor.stream_reader(data).read(size + 1)
        elif compression == '':
            content = data
        else:
            raise BagError(f'{source}: a chunk compressed with {compression[:20]!r}; '
                           'only lz4, zstd and none are read')
    except (RuntimeError, EOFError, zstandard.ZstdError, MemoryError):
        raise BagError(f'{source}: a chunk that cannot be decompressed') from None
    if len(content) != size:
        raise BagError(f'{source}: a chunk of another size than it says')
    return content


def open_chunk(content: bytes | memoryview, source: str, limit: int = MAX_RECORD,
               check: bool = True) -> bytes:
    """
    Return what a chunk holds: whole records of messages, schemas and channels.

    ``limit``: largest size that it may have [bytes]; ``check``: compare with the CRC; not needed
    where another one has proved the file.
    """
    at = _CHUNK_HEAD.size
    if len(content) < at + 12:
        raise BagError(f'{source}: a chunk of {len(content)} bytes')
    _, _, size, crc = _CHUNK_HEAD.unpack_from(content)
    if size > limit:
        raise BagError(f'{source}: a chunk that unpacks to {size} bytes; at most {limit} are '
                       'read here')
    length = int.from_bytes(content[at:at + 4], 'little')
    name = bytes(content[at + 4:at + 4 + length])
    at += 4 + length
    if length > 20 or int.from_bytes(content[at:at + 8], 'little') != len(content) - at - 8:
        raise BagError(f'{source}: a chunk whose lengths contradict each other')
    data = decompress(name.decode('utf-8', 'replace'), memoryview(content)[at + 8:], size, source)
    if check and crc not in (0, zlib.crc32(data)):
        raise BagError(f'{source}: a chunk that differs from its CRC')
    return bytes(data)
