"""One sqlite3 storage file of rosbag2, read by the standard library; damage is reported."""

import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import quote

from ur5_ros.bag.mcap.channels import TopicInfo, ros2_type
from ur5_ros.bag.mcap.message_index import Indexer, index_messages
from ur5_ros.bag.mcap.reader import BATCH_SIZE, Batch
from ur5_ros.bag.mcap.record_scan import opened
from ur5_ros.bag.mcap.records import MAX_RECORD, MESSAGE, MESSAGE_EXTRA, Opcode
from ur5_ros.errors import BagError

#: How a sqlite3 file begins.
SQLITE3_MAGIC = b'SQLite format 3\0'

#: What sqlite leaves beside a file whose writer was ended; committed messages may be there alone.
UNFINISHED = ('-wal', '-journal')

#: How a message begins that was compressed by rosbag2.
ZSTANDARD_MAGIC = b'\x28\xb5\x2f\xfd'

#: What a file is called that is none.
_OTHER = 'not an sqlite3 file; give the bag that was recorded'
_EMPTY = 'not an sqlite3 file: it holds nothing, its writer ended before the first record'

#: Rows that are fetched at once.
_ROWS = 2000


class Sqlite3Reader:
    """
    A ``.db3`` file as a source of messages.

    ``report`` takes a sentence about each defect; reading goes on where that is possible.
    BagError if the file cannot be opened or is not a bag, or its messages are compressed.

    """

    def __init__(self, path: Path, report: Callable[[str], None]) -> None:
        self.path = path
        self._copy: tempfile.TemporaryDirectory[str] | None = None
        self.metadata: list[tuple[str, dict[str, str]]] = []
        self.counts: dict[int, int] = {}
        self._report = report
        with opened(path) as file:
            self.size = path.stat().st_size
            start = file.read(len(SQLITE3_MAGIC))
            if start != SQLITE3_MAGIC:
                raise BagError(f'{path}: {_OTHER if start else _EMPTY}')
            try:
                self._opened = self._with_unfinished()
                self._topics = self._read_topics()
            except sqlite3.Error as error:
                raise BagError(f'{path}: not a bag of rosbag2, or damaged: {error}') from None

    def _with_unfinished(self) -> Path:
        """Return the file, or a copy that sqlite completes from what the writer left beside it."""
        beside = [Path(f'{self.path}{ending}') for ending in UNFINISHED]
        beside = [each for each in beside if each.is_file() and each.stat().st_size]
        if not beside:
            return self.path
        self._copy = tempfile.TemporaryDirectory(prefix='ur5-bag-')
        for each in (self.path, *beside):
            shutil.copyfile(each, Path(self._copy.name) / each.name)
        return Path(self._copy.name) / self.path.name

    def _connect(self) -> sqlite3.Connection:
        """Open the file for reading alone; nothing is created or changed beside it."""
        how = 'mode=rw' if self._copy else 'immutable=1'
        connection = sqlite3.connect(f'file:{quote(str(self._opened.absolute()))}?{how}',
                                     uri=True)
        connection.text_factory = lambda raw: raw.decode('utf-8', 'replace')
        return connection

    def _read_topics(self) -> dict[int, TopicInfo]:
        connection = self._connect()
        try:
            columns = {row[1] for row in connection.execute('PRAGMA table_info(topics)')}
            read_columns = ['id', 'name', 'type', 'serialization_format', 'offered_qos_profiles',
                      'type_description_hash']
            chosen = ', '.join(name if name in columns else "''" for name in read_columns)
            rows = connection.execute(f'SELECT {chosen} FROM topics').fetchall()
            definitions = self._read_definitions(connection)
        finally:
            connection.close()
        found = {}
        for number, name, kind, encoding, qos, type_hash in rows:
            text, form = definitions.get(str(kind), ('', ''))
            found[int(number)] = TopicInfo(
                str(name), ros2_type(str(kind), str(encoding)), str(encoding), form,
                text.encode(), str(qos), str(type_hash))
        return found

    def _read_definitions(self, connection: sqlite3.Connection) -> dict[str, tuple[str, str]]:
        """Return type -> (text, encoding) where the file defines its types, as since Iron."""
        try:
            rows = connection.execute('SELECT topic_type, encoded_message_definition, encoding '
                                      'FROM message_definitions').fetchall()
        except sqlite3.Error:
            return {}
        return {str(kind): (str(text), str(form)) for kind, text, form in rows
                if form == 'ros2msg' and text}

    @property
    def topics(self) -> dict[int, TopicInfo]:
        """The topics by number."""
        return self._topics

    @property
    def expected(self) -> dict[int, int]:
        """Nothing: the messages would have to be counted for it."""
        return {}

    def batches(self, index: Indexer = index_messages) -> Iterator[Batch]:
        """Yield all messages, by log time, as records like those of an MCAP file."""
        self.counts = {}
        buffer = bytearray()
        for number, time, data in self._rows():
            if number not in self._topics or not 0 <= time < 2**63 or len(data) > MAX_RECORD:
                self._report(f'{self.path}: a message of topic {number} with an impossible topic, '
                             'time or size was left out')
                continue
            self.counts[number] = self.counts.get(number, 0) + 1
            buffer += MESSAGE.pack(Opcode.MESSAGE, MESSAGE_EXTRA + len(data), number, 0, time,
                                   time)
            buffer += data
            if len(buffer) > BATCH_SIZE:
                yield from _batch(buffer, index)
                buffer = bytearray()
        yield from _batch(buffer, index)

    def _rows(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield (topic, log time [ns], data) of whole rows, up to the first damaged page."""
        connection = self._connect()
        try:
            cursor = connection.execute('SELECT topic_id, timestamp, data FROM messages '
                                        'ORDER BY timestamp, id')
            while rows := cursor.fetchmany(_ROWS):
                for number, time, data in rows:
                    if isinstance(data, bytes) and data.startswith(ZSTANDARD_MAGIC):
                        raise BagError(f'{self.path}: its messages are compressed; convert it '
                                       'to one without compression: ros2 bag convert')
                    if (isinstance(number, int) and isinstance(time, int)
                            and isinstance(data, bytes) and 0 <= number < 2**16):
                        yield number, time, data
                    else:
                        self._report(f'{self.path}: a row of messages that is not a topic, a '
                                     'time and bytes was left out')
        except sqlite3.Error as error:
            self._report(f'{self.path}: is damaged, the rest was left out: {error}')
        finally:
            connection.close()


def _batch(buffer: bytearray, index: Indexer) -> Iterator[Batch]:
    content = bytes(buffer)
    found = index(content)
    if found is not None:
        yield Batch(content, found)
