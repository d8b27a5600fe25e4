"""Reading of bags, finished or not; what is wrong with them is listed."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.bag.arrays.collector import Collector, RawCollector
from ur5_ros.bag.arrays.columns import COLUMN_TYPES, Columns, RawColumns
from ur5_ros.bag.mcap.channels import TopicInfo
from ur5_ros.bag.mcap.message_index import CompiledMessageIndex, MessageIndex, index_messages
from ur5_ros.bag.mcap.reader import Batch, MessageSource
from ur5_ros.bag.sources import (
    compare_counts,
    open_sources,
    read_descriptions,
    report_missing_metadata,
)
from ur5_ros.cdr.codec import Definitions, decode, definitions_of
from ur5_ros.errors import BagError, InputError, one_line

#: Bags larger than this are indexed by compiled code, which takes a second to load [bytes].
COMPILE_ABOVE = 16 << 20

#: Rows that a summary may claim, for each byte of the file.
MAX_ROWS_PER_BYTE = 4

#: Sentences that are kept about one bag.
MAX_PROBLEMS = 1000


def open_bag(path: Path | str) -> 'Bag':
    """
    Return a bag: a rosbag2 folder, or a single MCAP or sqlite3 file.

    Parameters
    ----------
    path : path
        The folder with metadata.yaml, or at least with storage files; or one ``.mcap`` or
        ``.db3`` file.

    Raises
    ------
    BagError
        If nothing of it can be read.
    InputError
        If there is no such folder, or its storage is compressed or of another kind.

    Examples
    --------
    >>> from ur5_ros import open_bag, run_closed_loop, run_config
    >>> _ = run_closed_loop(run_config('joint_step', duration=0.5), folder='opened')
    >>> bag = open_bag('opened/sim')
    >>> bag.topics['/joint_states'], bag.joint_states('/joint_states').position.shape
    ('sensor_msgs/msg/JointState', (500, 6))

    """
    return Bag(Path(path))


class Bag:
    """
    What a bag holds; nothing of the messages is kept in memory.

    Reading goes on past damage where that is possible: what was found wrong or missing is in
    ``problems``, which grows while messages are read. Look at it after reading, or :meth:`check`.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._problems: dict[str, None] = {}
        self._information, self.sources = open_sources(path, self.report)
        self.topics: dict[str, str] = {}
        """Topic -> type."""
        for source in self.sources:
            for info in source.topics.values():
                if self.topics.setdefault(info.name, info.type) != info.type:
                    self.report(f'{path}: topic {info.name} has two types; only '
                                 f'{self.topics[info.name]} is read')
        self.description: dict[str, str]
        """The description that the bag holds; see ur5_ros.bag.description."""
        self.notes: dict[str, dict[str, Any]]
        """Notes that were added while recording: name -> values; the last of a name."""
        self.description, self.notes = read_descriptions(path, self._information, self.sources,
                                                         self.report)
        report_missing_metadata(path, self.sources, bool(self.description), self.report)

    def report(self, problem: str) -> None:
        """Add what was found wrong or missing to ``problems``: one line, each once."""
        if len(self._problems) < MAX_PROBLEMS:
            self._problems[one_line(problem)] = None

    @property
    def problems(self) -> list[str]:
        """What was found wrong or missing so far, one sentence each."""
        return list(self._problems)

    @property
    def complete(self) -> bool:
        """Whether nothing was found wrong or missing so far."""
        return not self._problems

    def _batches(self) -> Iterator[tuple[MessageSource, Batch]]:
        """Yield all batches of all files; afterwards compare the counts with metadata.yaml."""
        large = sum(source.size for source in self.sources) > COMPILE_ABOVE
        index = CompiledMessageIndex() if large else index_messages
        for source in self.sources:
            for batch in source.batches(index):
                yield source, batch
        compare_counts(self.path, self._information, self.sources, self.report)

    def counts(self) -> dict[str, int]:
        """Return topic -> messages, as counted by the last whole reading or :meth:`check`."""
        found = dict.fromkeys(self.topics, 0)
        for source in self.sources:
            for channel, info in source.topics.items():
                found[info.name] += source.counts.get(channel, 0)
        return found

    def check(self) -> list[str]:
        """Read all of the bag, every CRC and count, and return the problems."""
        for _ in self._batches():
            pass
        return self.problems

    def _info(self, topic: str) -> TopicInfo:
        for source in self.sources:
            for info in source.topics.values():
                if info.name == topic and info.type in ('', self.topics[topic]):
                    return info
        known = ', '.join(sorted(self.topics)) or 'none'
        raise InputError(one_line(f'{self.path}: no topic {topic}; there are: {known}'))

    def definitions(self, topic: str) -> Definitions:
        """Return the definitions of a topic's type; BagError if they cannot be read."""
        info = self._info(topic)
        try:
            return definitions_of(self.topics[topic]) if not info.type else info.definitions()
        except BagError as problem:
            raise BagError(f'{self.path}: {problem}') from None

    def form(self, topic: str) -> str:
        """Return ``ros2`` where messages are CDR of the ROS 2 type, ``other`` where not."""
        info = self._info(topic)
        return 'ros2' if info.is_ros2 and info.encoding == 'cdr' else 'other'

    def declare(self, topic: str, type_name: str) -> None:
        """Set the type of a topic whose file states none."""
        self.topics[topic] = type_name

    def _pass(self, collectors: Mapping[str, Any]) -> None:
        """Hand the messages of each topic to its collector, in one pass over the bag."""
        for source, batch in self._batches():
            channels_of: dict[str, list[int]] = {}
            for channel, info in source.topics.items():
                if info.name in collectors and info.type in ('', self.topics[info.name]):
                    channels_of.setdefault(info.name, []).append(channel)
            for topic, channels in channels_of.items():
                chosen = np.isin(batch.messages.channels, channels)
                if chosen.any():
                    collectors[topic].add(batch.buffer, _select(batch.messages, chosen))

    def _expected(self, topic: str) -> int:
        """Return how many messages the summaries claim, as far as the files could hold them."""
        return sum(min(source.expected.get(channel, 0), MAX_ROWS_PER_BYTE * source.size)
                   for source in self.sources for channel, info in source.topics.items()
                   if info.name == topic)

    def load(self, topics: Mapping[str, Sequence[str] | None]) -> dict[str, Any]:
        """
        Return the messages of several topics as arrays, in one pass over the bag.

        Parameters
        ----------
        topics : mapping
            Topic -> names of the columns, None for those of the first message.

        Returns
        -------
        dict
            Topic -> :class:`Columns` for the types of ``columns.COLUMN_TYPES``, RawColumns for
            others; in the order of the file.

        Raises
        ------
        InputError
            If there is no such topic.
        BagError
            If its messages are not CDR, or its type is not defined as in ROS 2.

        """
        collectors = {}
        for topic, names in topics.items():
            definitions, type_name = self.definitions(topic), self.topics[topic]
            collectors[topic] = Collector(
                topic, type_name, definitions, names, self.report, self._expected(topic)) \
                if type_name in COLUMN_TYPES else RawCollector()
        self._pass(collectors)
        return {topic: collector.result() for topic, collector in collectors.items()}

    def columns(self, topic: str) -> RawColumns:
        """Return the messages of one topic as bytes; see :meth:`load` for what is raised."""
        self._info(topic)
        collector = RawCollector()
        self._pass({topic: collector})
        return collector.result()

    def joint_states(self, topic: str, names: Sequence[str] | None = None) -> Columns:
        """
        Return a sensor_msgs/JointState topic as arrays.

        Parameters
        ----------
        topic : str
            Name of the topic in the bag.
        names : sequence of str, optional
            Joints in the order of the columns; those of the first message if not given.

        Returns
        -------
        Columns
            Stamps [ns], shape (n,); position [rad], velocity [rad/s] and effort [N m], each of
            shape (n, number of joints).

        Raises
        ------
        InputError
            If the topic is not there or of another type.
        BagError
            As :meth:`load`.

        """
        info = self._info(topic)
        if info.type != 'sensor_msgs/msg/JointState':
            raise InputError(f'{self.path}: topic {topic} is {info.type}, '
                             'not sensor_msgs/msg/JointState')
        columns = self.load({topic: names})[topic]
        assert isinstance(columns, Columns)
        return columns

    def messages(self, topic: str) -> Iterator[tuple[int, dict[str, Any]]]:
        """
        Yield (log time [ns], fields) of each message of a topic that can be read.

        Raises
        ------
        InputError, BagError
            As :meth:`load`.

        """
        info = self._info(topic)
        return self._decoded(info, partial(decode, info.type, definitions=info.definitions()))

    def _decoded(self, info: TopicInfo, read) -> Iterator[tuple[int, dict[str, Any]]]:
        for source, batch in self._batches():
            channels = [number for number, other in source.topics.items()
                        if (other.name, other.type) == (info.name, info.type)]
            found = _select(batch.messages, np.isin(batch.messages.channels, channels))
            for begin, length, log_time in zip(found.offsets.tolist(), found.lengths.tolist(),
                                               found.log_times.tolist(), strict=True):
                try:
                    message = read(bytes(batch.buffer[begin:begin + length]))
                except BagError as problem:
                    self.report(f'topic {info.name}: {problem}')
                    continue
                yield log_time, message


def _select(found: MessageIndex, chosen: np.ndarray) -> MessageIndex:
    """Return some of the messages of an index."""
    return MessageIndex(found.channels[chosen], found.offsets[chosen], found.lengths[chosen],
                        found.log_times[chosen], found.publish_times[chosen], [])
