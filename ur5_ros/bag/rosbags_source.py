"""Bags in sqlite3 storage, read through the rosbags package where it is installed."""

from collections.abc import Callable, Iterator
from pathlib import Path

from ur5_ros.bag.mcap.channels import TopicInfo
from ur5_ros.bag.mcap.message_index import Indexer, index_messages
from ur5_ros.bag.mcap.reader import BATCH_SIZE, Batch
from ur5_ros.bag.mcap.records import MAX_RECORD, MESSAGE, MESSAGE_EXTRA, Opcode
from ur5_ros.bag.metadata import Information
from ur5_ros.errors import BagError, InputError


class RosbagsSource:
    """
    A whole bag folder in sqlite3 storage as a source of messages.

    Parameters
    ----------
    path : pathlib.Path
        The folder.
    information : Information
        What its metadata.yaml says.
    report : callable
        Takes a sentence about each thing found wrong.

    Raises
    ------
    InputError
        If the storage is another one, or rosbags is not installed.
    BagError
        If rosbags cannot open it.

    """

    def __init__(self, path: Path, information: Information,
                 report: Callable[[str], None]) -> None:
        if information.compression_mode or information.storage_identifier != 'sqlite3':
            what = f'storage {information.storage_identifier[:20]!r}' \
                + (f' compressed by {information.compression_mode[:20]}'
                   if information.compression_mode else '')
            raise InputError(f'{path}: {what} is not read; write it anew as mcap with: '
                             'ros2 bag convert')
        try:
            from rosbags.rosbag2 import Reader
        except ImportError:
            raise InputError(f'{path}: sqlite3 storage is read through rosbags; install it with: '
                             'pip install rosbags') from None
        self.path = path
        self.metadata: list[tuple[str, dict[str, str]]] = []
        self.counts: dict[int, int] = {}
        self._topics: dict[int, TopicInfo] = {}
        self.size = sum(file.stat().st_size for file in path.glob('*.db3'))
        self._report = report
        self._reader = Reader
        try:
            with Reader(path) as reader:
                for number, each in enumerate(reader.connections, start=1):
                    text = each.msgdef.data
                    self._topics[number] = TopicInfo(
                        each.topic, each.msgtype, getattr(each.ext, 'serialization_format', ''),
                        'ros2msg' if text and each.msgdef.format.name == 'MSG' else '',
                        text.encode(), '', each.digest)
        except Exception as error:  # rosbags and sqlite raise many kinds on damaged files
            raise BagError(f'{path}: rosbags cannot read it: {_line(error)}') from None

    @property
    def topics(self) -> dict[int, TopicInfo]:
        """What is known of each topic, under numbers of our own."""
        return self._topics

    @property
    def expected(self) -> dict[int, int]:
        """Nothing: the storage has to be asked for it."""
        return {}

    def batches(self, index: Indexer = index_messages) -> Iterator[Batch]:
        """Yield all messages, by log time, as records like those of an MCAP file."""
        self.counts = {}
        numbers = {(info.name, info.type): number for number, info in self.topics.items()}
        buffer = bytearray()
        try:
            with self._reader(self.path) as reader:
                for connection, time, data in reader.messages():
                    number = numbers[connection.topic, connection.msgtype]
                    if not 0 <= time < 2**64 or len(data) > MAX_RECORD:
                        self._report(f'{self.path}: a message on {connection.topic} with an '
                                     'impossible time or size was left out')
                        continue
                    self.counts[number] = self.counts.get(number, 0) + 1
                    buffer += MESSAGE.pack(Opcode.MESSAGE, MESSAGE_EXTRA + len(data), number, 0,
                                           time, time)
                    buffer += data
                    if len(buffer) > BATCH_SIZE:
                        yield from self._batch(buffer, index)
                        buffer = bytearray()
        except GeneratorExit:
            raise
        except Exception as error:
            self._report(f'{self.path}: rosbags cannot read on: {_line(error)}')
        yield from self._batch(buffer, index)

    def _batch(self, buffer: bytearray, index: Indexer) -> Iterator[Batch]:
        content = bytes(buffer)
        found = index(content)
        if found is not None:
            yield Batch(content, found)


def _line(error: Exception) -> str:
    """Return the first line of what an exception says."""
    return (str(error) or type(error).__name__).partition('\n')[0][:200]
