"""A rosbag2 folder, written file by file: splitting, definitions in each file, metadata.yaml."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Schema

from ur5_ros.bag.mcap.chunk import Message, cut
from ur5_ros.bag.mcap.records import checked
from ur5_ros.bag.mcap.writer import McapWriter
from ur5_ros.bag.metadata import FileEntry, TopicEntry, describe_bag, to_yaml, write_metadata

#: Names of this package's metadata records: the description, and the prefix of a note.
DESCRIPTION_RECORD = 'ur5_ros'
NOTE_RECORD = 'ur5_ros/'

#: rosbag2's own metadata record.
ROSBAG2_RECORD = 'rosbag2'


class TopicRecords(NamedTuple):
    """The records that announce a topic in every file of a bag."""

    schema: Schema
    channel: Channel
    qos: Sequence[Mapping[str, Any]]
    type_hash: str


def make_topic(number: int, schema_id: int, name: str, schema: tuple[str, bytes],
               qos: Sequence[Mapping[str, Any]], type_hash: str,
               schema_encoding: str = 'ros2msg', encoding: str = 'cdr') -> TopicRecords:
    """Return the records of a topic; ``schema`` is (type name, text)."""
    type_name, text = schema
    metadata = {'offered_qos_profiles': to_yaml([dict(profile) for profile in qos]),
                'topic_type_hash': type_hash}
    return TopicRecords(Schema(id=schema_id, name=type_name, encoding=schema_encoding, data=text),
                 Channel(id=number, schema_id=schema_id, topic=name, message_encoding=encoding,
                         metadata=metadata),
                 qos, type_hash)


#: Log times of messages handed over together differ from their order by less than this [ns].
_DISORDER = 1_000_000_000


class BagFolder:
    """
    The files ``<name>_<n>.mcap`` of one bag; every method that writes raises OSError.

    The folder is made here and must not exist. ``max_duration`` [ns of log time] and ``max_size``
    [bytes] limit one file; 0 = no limit.

    """

    def __init__(self, folder: Path, name: str, description: Mapping[str, str],
                 max_duration: int = 0, max_size: int = 0) -> None:
        self.folder = folder
        self.topics: list[TopicRecords] = []
        self.written = 0
        """Messages handed to the disk so far."""
        self._name = name
        self._description = dict(description)
        self._max_duration = max_duration
        self._max_size = max_size
        self._counts: dict[int, int] = {}
        self._files: list[FileEntry] = []
        folder.mkdir(parents=True)
        self._file = self._open()

    def _open(self) -> McapWriter:
        file = McapWriter(self.folder / f'{self._name}_{len(self._files)}.mcap')
        if self._description:
            file.note(DESCRIPTION_RECORD, checked(DESCRIPTION_RECORD, self._description))
        return file

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Write a note: a metadata record of the file that is open."""
        self._file.note(NOTE_RECORD + name, checked(NOTE_RECORD + name, values))

    def write(self, messages: Sequence[Message]) -> None:
        """Write messages in chunks, into the next file where this one is full."""
        at = 0
        while at < len(messages):
            if self._is_full(messages[at]):
                self.next_file()
            self._announce()
            for chunk in cut(messages[at:self._end_of_file(messages, at)]):
                self._file.write(chunk)
                at += len(chunk)
                self.written += len(chunk)
                if self._max_size and self._file.size >= self._max_size:
                    break

    def next_file(self) -> None:
        """Complete the open file and start another one."""
        self._close_file()
        self._file = self._open()

    def _announce(self) -> None:
        """Define the topics that the open file does not have yet."""
        for topic in self.topics:
            if not self._file.defines(topic.channel.id):
                self._file.define(topic.schema, topic.channel)

    def _is_full(self, message: Message) -> bool:
        if self._file.start is None:
            return False
        return bool((self._max_duration and message[1] >= self._file.start + self._max_duration)
                    or (self._max_size and self._file.size >= self._max_size))

    def _end_of_file(self, messages: Sequence[Message], begin: int) -> int:
        """Return the index behind the last message that the open file takes, by log time."""
        if not self._max_duration:
            return len(messages)
        start = messages[begin][1] if self._file.start is None else self._file.start
        limit = start + self._max_duration
        if messages[-1][1] + _DISORDER < limit:  # nearly always: no need to look at each
            return len(messages)
        return next((at for at in range(begin + 1, len(messages)) if messages[at][1] >= limit),
                    len(messages))

    def _close_file(self) -> None:
        file = self._file
        entry = FileEntry(file.path.name, file.start, file.end, sum(file.counts.values()))
        self._announce()
        file.note(ROSBAG2_RECORD, {'serialized_metadata': to_yaml(
            describe_bag([entry], self._entries(file.counts), self._description))})
        file.finish()
        self._files.append(entry)
        for channel, number in file.counts.items():
            self._counts[channel] = self._counts.get(channel, 0) + number

    def _entries(self, counts: Mapping[int, int]) -> list[TopicEntry]:
        return [TopicEntry(topic.channel.topic, topic.schema.name, topic.qos, topic.type_hash,
                           counts.get(topic.channel.id, 0)) for topic in self.topics]

    def finish(self) -> None:
        """Complete the open file and write metadata.yaml."""
        self._close_file()
        write_metadata(self.folder, describe_bag(self._files, self._entries(self._counts),
                                                 self._description))

    @property
    def kept(self) -> int:
        """Messages in files that are still there."""
        return self.written - (sum(self._file.counts.values()) if self._file.removed else 0)

    def abandon(self) -> None:
        """Leave the open file with its last whole record, unfinished."""
        self._file.abandon()
