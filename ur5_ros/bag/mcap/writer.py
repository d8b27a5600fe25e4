"""One MCAP file, written: chunks, their indexes, the summary."""

import errno
import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from ur5_ros.bag.mcap.chunk import Message, PackedChunk, pack_chunk
from ur5_ros.bag.mcap.records import MAGIC, Opcode, record_bytes

LIBRARY = 'ur5_ros'


class McapWriter:
    """
    An MCAP file of profile ``ros2``, as rosbag2 stores it.

    Every method that writes raises OSError where the disk does; :meth:`abandon` then leaves a
    file that ends with the last whole record. The file must not exist.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.size = 0
        self.counts: dict[int, int] = {}
        """Messages of each channel."""
        self.start: int | None = None
        """Smallest log time [ns], None while there is no message."""
        self.end = 0
        self.removed = False
        """Whether the file was deleted while it was open."""
        self._crc = 0
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._new = b''
        self._chunks = bytearray()
        self._chunk_count = 0
        self._metadata: list[MetadataIndex] = []
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        self._write(MAGIC + record_bytes(Header(profile='ros2', library=LIBRARY)))

    def _write(self, data: bytes) -> None:
        """Write all of ``data``; only then does it count."""
        if os.fstat(self._file).st_nlink == 0:
            self.removed = True
            raise FileNotFoundError(errno.ENOENT, 'the file was deleted')
        left = memoryview(data)
        while left:
            left = left[os.write(self._file, left):]
        self.size += len(data)
        self._crc = zlib.crc32(data, self._crc)

    def define(self, schema: Schema, channel: Channel) -> None:
        """Announce a topic: in the file itself and, under a CRC, in the next chunk."""
        records: list[McapRecord] = [channel]
        if schema.id not in self._schemas and schema.id:
            self._schemas[schema.id] = schema
            records.insert(0, schema)
        self._channels[channel.id] = channel
        self.counts[channel.id] = 0
        data = record_bytes(*records)
        self._write(data)
        self._new += data

    def defines(self, channel_id: int) -> bool:
        """Return whether a channel has been announced."""
        return channel_id in self._channels

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Write a metadata record."""
        data = record_bytes(Metadata(name=name, metadata=dict(values)))
        self._metadata.append(MetadataIndex(offset=self.size, length=len(data), name=name))
        self._write(data)

    def write(self, messages: Sequence[Message]) -> PackedChunk:
        """Write one chunk of messages of announced channels."""
        chunk = pack_chunk(self._new, messages)
        for channel in chunk.counts:
            self._channels[channel]  # KeyError before anything of an unknown one is written
        at = self.size
        index_at, offsets = at + len(chunk.record), {}
        for channel, index in chunk.indexes.items():
            offsets[channel] = index_at
            index_at += len(index)
        self._write(chunk.record + b''.join(chunk.indexes.values()))
        self._chunks += record_bytes(ChunkIndex(
            chunk_start_offset=at, chunk_length=len(chunk.record), compression='lz4',
            compressed_size=chunk.compressed_size, uncompressed_size=chunk.uncompressed_size,
            message_start_time=chunk.start, message_end_time=chunk.end,
            message_index_offsets=offsets,
            message_index_length=self.size - at - len(chunk.record)))
        self._chunk_count += 1
        self._new = b''
        for channel, number in chunk.counts.items():
            self.counts[channel] += number
        self.start = chunk.start if self.start is None else min(self.start, chunk.start)
        self.end = max(self.end, chunk.end)
        return chunk

    def finish(self) -> None:
        """Write the summary and close; the file is complete only afterwards."""
        self._write(record_bytes(DataEnd(data_section_crc=self._crc)))
        groups = (
            (Opcode.SCHEMA, record_bytes(*self._schemas.values())),
            (Opcode.CHANNEL, record_bytes(*self._channels.values())),
            (Opcode.STATISTICS, record_bytes(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunks)),
            (Opcode.METADATA_INDEX, record_bytes(*self._metadata)),
        )
        summary, offsets = b'', []
        for opcode, group in groups:
            if group:
                offsets.append(SummaryOffset(group_opcode=opcode, group_length=len(group),
                                             group_start=self.size + len(summary)))
            summary += group
        footer = Footer(summary_start=self.size, summary_offset_start=self.size + len(summary),
                        summary_crc=0)
        summary += record_bytes(*offsets)
        plain = record_bytes(footer)
        footer.summary_crc = zlib.crc32(summary + plain[:-4])
        self._write(summary + record_bytes(footer) + MAGIC)
        os.close(self._file)

    def _statistics(self) -> Statistics:
        return Statistics(
            message_count=sum(self.counts.values()), schema_count=len(self._schemas),
            channel_count=len(self._channels), attachment_count=0,
            metadata_count=len(self._metadata), chunk_count=self._chunk_count,
            message_start_time=self.start or 0, message_end_time=self.end,
            channel_message_counts=dict(self.counts))

    def abandon(self) -> None:
        """Cut off a record that was written in part and close; the file stays unfinished."""
        try:
            os.ftruncate(self._file, self.size)
        finally:
            os.close(self._file)
