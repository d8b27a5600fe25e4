"""The summary at the end of an MCAP file: what is in it, without reading all of it."""

import zlib
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.records import ChunkIndex, Footer, Metadata, MetadataIndex, Statistics

from ur5_ros.bag.mcap.channels import FileDefinitions
from ur5_ros.bag.mcap.records import FRAME, MAGIC, MAX_RECORD, Opcode, parse_record
from ur5_ros.errors import BagError

_FOOTER_CONTENT = 20
_TAIL = FRAME.size + _FOOTER_CONTENT + len(MAGIC)


class Summary(NamedTuple):
    """The summary of a file."""

    start: int
    """Its offset; the record of the end of data is right before."""
    statistics: Statistics | None
    metadata: list[tuple[str, dict[str, str]]]
    """Metadata records: (name, content)."""
    indexes: list[bytes]
    """Chunk index records, unread: only a damaged file needs them."""

    def chunks(self, path: Path) -> list[tuple[int, int]]:
        """Return (offset, length) of each chunk, without overlaps; BagError if damaged."""
        found, end = [], len(MAGIC)
        for content in self.indexes:
            index = parse_record(ChunkIndex, content, str(path))
            if end <= index.chunk_start_offset <= self.start - index.chunk_length:
                found.append((index.chunk_start_offset, index.chunk_length))
                end = index.chunk_start_offset + index.chunk_length
        return found


def read_summary(file: BinaryIO, path: Path, size: int,
                 definitions: FileDefinitions) -> Summary | None:
    """
    Return the summary of a file, None if its writer did not close it; BagError for a damaged one.

    ``definitions`` receives the schemas and channels.

    """
    if size < len(MAGIC) + _TAIL:
        return None
    file.seek(size - _TAIL)
    tail = file.read(_TAIL)
    if FRAME.unpack_from(tail) != (Opcode.FOOTER, _FOOTER_CONTENT) or not tail.endswith(MAGIC):
        return None
    footer = parse_record(Footer, tail[FRAME.size:-len(MAGIC)], str(path))
    start, end = footer.summary_start, size - _TAIL
    if start == 0:  # closed by a writer that keeps no summary
        return Summary(end, None, [], [])
    if not len(MAGIC) < start <= end or end - start > MAX_RECORD:
        raise BagError(f'{path}: its summary is damaged')
    file.seek(start)
    summary = file.read(end - start)
    crc = zlib.crc32(summary + tail[:-len(MAGIC) - 4])
    if footer.summary_crc not in (0, crc):
        raise BagError(f'{path}: its summary is damaged (CRC)')

    statistics, indexes, chunks = None, [], []
    for opcode, content in _records(summary, path):
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            definitions.add(opcode, content)
        elif opcode == Opcode.STATISTICS:
            statistics = parse_record(Statistics, content, str(path))
        elif opcode == Opcode.METADATA_INDEX:
            indexes.append(parse_record(MetadataIndex, content, str(path)))
        elif opcode == Opcode.CHUNK_INDEX:
            chunks.append(content)
    metadata = [_metadata(file, path, index, start) for index in indexes]
    return Summary(start, statistics, metadata, chunks)


def _records(data: bytes, path: Path) -> list[tuple[int, bytes]]:
    """Return the records of a buffer: (opcode, content)."""
    found, at = [], 0
    while at < len(data):
        if at + FRAME.size > len(data):
            raise BagError(f'{path}: its summary is damaged')
        opcode, length = FRAME.unpack_from(data, at)
        at += FRAME.size + length
        if at > len(data):
            raise BagError(f'{path}: its summary is damaged')
        found.append((opcode, data[at - length:at]))
    return found


def _metadata(file: BinaryIO, path: Path, index: MetadataIndex,
              end: int) -> tuple[str, dict[str, str]]:
    """Return a metadata record from the place that its index names."""
    if index.offset + index.length > end or not FRAME.size <= index.length <= MAX_RECORD:
        raise BagError(f'{path}: its summary names a metadata record that is not there')
    file.seek(index.offset)
    data = file.read(index.length)
    if FRAME.unpack_from(data) != (Opcode.METADATA, index.length - FRAME.size):
        raise BagError(f'{path}: its summary names a metadata record that is not there')
    record = parse_record(Metadata, data[FRAME.size:], str(path))
    return record.name, record.metadata
