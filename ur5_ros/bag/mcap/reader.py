"""One MCAP file, read from front to back within bounds; damage is reported and passed over."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol

import numpy as np
from mcap.records import Header, Metadata

from ur5_ros.bag.mcap.channels import FileDefinitions, TopicInfo
from ur5_ros.bag.mcap.chunk import open_chunk
from ur5_ros.bag.mcap.data_section import check_data, data_records
from ur5_ros.bag.mcap.message_index import Indexer, MessageIndex, index_messages
from ur5_ros.bag.mcap.record_scan import opened
from ur5_ros.bag.mcap.records import FRAME, MAGIC, MAX_RECORD, Opcode, parse_record
from ur5_ros.bag.mcap.summary import Summary, read_summary
from ur5_ros.errors import BagError
from ur5_ros.wording import number_of

#: Chunks are indexed together up to this size [bytes].
BATCH_SIZE = 1 << 20

#: Largest ratio of decompressed to stored size of a whole file, beyond the first bytes
#: (ALWAYS_ALLOWED).
#: LZ4 cannot exceed 255; states of an arm at rest come to 40 with Zstandard.
MAX_RATIO = 1000
ALWAYS_ALLOWED = 4 << 20


class Batch(NamedTuple):
    """A buffer of records, and the index of its messages."""

    buffer: bytes | bytearray
    messages: MessageIndex


class MessageSource(Protocol):
    """A storage of messages: an MCAP file, or a sqlite3 database."""

    path: Path
    size: int
    metadata: list[tuple[str, dict[str, str]]]
    counts: dict[int, int]

    @property
    def topics(self) -> dict[int, TopicInfo]:
        """The channels by number."""

    @property
    def expected(self) -> dict[int, int]:
        """Messages of each channel, as the storage itself states."""

    def batches(self, index: Indexer = index_messages) -> Iterator[Batch]:
        """Yield all messages."""


class McapReader:
    """
    An MCAP file as a source of messages.

    ``report`` takes a sentence about each defect; reading goes on where that is possible.
    BagError if the file cannot be opened or is no MCAP file.

    """

    def __init__(self, path: Path, report: Callable[[str], None]) -> None:
        self.path = path
        self.report = report
        self.metadata: list[tuple[str, dict[str, str]]] = []
        """Metadata records: (name, content)."""
        self.counts: dict[int, int] = {}
        """Messages of each channel, as counted by the last whole pass."""
        self.summary: Summary | None = None
        self._definitions = FileDefinitions(path, report)
        with opened(path) as file:
            self.size = path.stat().st_size
            start = file.read(len(MAGIC))
            if start == MAGIC:
                self._survey(file)
        if start != MAGIC:
            if not MAGIC.startswith(start):
                raise BagError(f'{path}: not an MCAP file; give the bag that was recorded')
            report(f'{path}: holds nothing; its writer ended before the first record')

    def _survey(self, file: BinaryIO) -> None:
        """Read topics and metadata: from the summary, or by a whole pass where there is none."""
        try:
            self.summary = read_summary(file, self.path, self.size, self._definitions)
        except BagError as problem:
            self.report(str(problem))
            self._definitions.forget()
        if self.summary is not None:
            self.metadata = list(self.summary.metadata)
        else:
            self.report(f'{self.path}: unfinished, its writer was ended before it closed the '
                        'file; repair it with: ur5 recover')
        if self.summary is None or not self._definitions.channels:
            for _ in self.batches():
                pass

    @property
    def topics(self) -> dict[int, TopicInfo]:
        """The channels by number."""
        return self._definitions.topics()

    @property
    def expected(self) -> dict[int, int]:
        """Messages of each channel, as the summary claims."""
        stated = self.summary and self.summary.statistics
        return stated.channel_message_counts if stated else {}

    def batches(self, index: Indexer = index_messages) -> Iterator[Batch]:
        """Yield all messages of the file, in its order; afterwards ``counts`` is right."""
        self.counts = {}
        for contents in self._gathered():
            joined = b''.join(contents) if len(contents) > 1 else contents[0]
            found = index(joined)
            if found is not None:
                yield self._counted(joined, found)
                continue
            for content in contents:
                found = index_messages(content)
                if found is None:
                    self.report(f'{self.path}: a chunk that holds no whole records was left out')
                else:
                    yield self._counted(content, found)
        self._check_counts()

    def _counted(self, content: bytes, found: MessageIndex) -> Batch:
        for opcode, begin, end in found.definitions:
            self._define(opcode, bytes(content[begin:end]))
        channels, numbers = np.unique(found.channels, return_counts=True)
        for channel, number in zip(channels.tolist(), numbers.tolist(), strict=True):
            self.counts[channel] = self.counts.get(channel, 0) + number
            if channel not in self._definitions.channels:
                self.report(f'{self.path}: messages of channel {channel}, which is not defined, '
                            'were left out')
        return Batch(content, found)

    def _check_counts(self) -> None:
        """Report a summary that does not fit what is in the file."""
        stated = self.summary and self.summary.statistics
        if not stated:
            return
        counted = {channel: number for channel, number in self.counts.items() if number}
        listed = {channel: number for channel, number in stated.channel_message_counts.items()
                  if number}
        if sum(counted.values()) != stated.message_count or (listed and listed != counted):
            self.report(f'{self.path}: holds {number_of(sum(counted.values()), "message")}; its '
                        f'statistics say {stated.message_count}')

    def _gathered(self) -> Iterator[list[bytes]]:
        """Yield contents of chunks, several together up to BATCH_SIZE."""
        gathered: list[bytes] = []
        size = 0
        for content in self._contents():
            gathered.append(content)
            size += len(content)
            if size >= BATCH_SIZE:
                yield gathered
                gathered, size = [], 0
        if gathered:
            yield gathered

    def _contents(self) -> Iterator[bytes]:
        """Yield buffers of message and definition records: chunks, and those outside of them."""
        loose = bytearray()
        chunked = stray = False
        sound, start = check_data(self.path, self.summary, self.report)
        allowed = ALWAYS_ALLOWED + MAX_RATIO * self.size
        for opcode, record in data_records(
                self.path, self.size, self.summary, sound is False, self.report, start):
            if opcode == Opcode.MESSAGE and chunked:
                stray = True
            elif opcode == Opcode.MESSAGE:
                loose += record
                if len(loose) > BATCH_SIZE:
                    yield bytes(loose)
                    loose = bytearray()
            elif opcode == Opcode.CHUNK:
                chunked, stray, loose = True, stray or bool(loose), bytearray()
                try:
                    content = open_chunk(record[FRAME.size:], str(self.path),
                                         min(allowed, MAX_RECORD), check=sound is not True)
                except BagError as problem:
                    self.report(f'{problem}; it was left out')
                    continue
                allowed -= len(content)
                yield content
            else:
                self._other(opcode, bytes(record[FRAME.size:]))
        if loose:
            yield bytes(loose)
        if stray:  # writers use chunks or do not: these are records whose kind was damaged
            self.report(f'{self.path}: messages outside of the chunks were left out')

    def _define(self, opcode: int, content: bytes) -> None:
        try:
            self._definitions.add(opcode, content)
        except BagError as problem:
            self.report(str(problem))

    def _other(self, opcode: int, content: bytes) -> None:
        """Add or check a record that is neither a message nor a chunk."""
        source = str(self.path)
        try:
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._definitions.add(opcode, content)
            elif opcode == Opcode.METADATA:
                record = parse_record(Metadata, content, source)
                if (record.name, record.metadata) not in self.metadata:
                    self.metadata.append((record.name, record.metadata))
            elif opcode == Opcode.HEADER:
                parse_record(Header, content, source)
            elif opcode == Opcode.MESSAGE_INDEX:
                if len(content) < 6 or int.from_bytes(content[2:6], 'little') != len(content) - 6:
                    raise BagError(f'{source}: a damaged message index')
            elif opcode == Opcode.ATTACHMENT:
                pass
            else:
                raise BagError(f'{source}: a record of kind {opcode:#04x} among the data')
        except BagError as problem:
            self.report(str(problem))
