"""Schemas and channels of an MCAP file: the types of its messages."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Schema

from ur5_ros.bag.mcap.records import Opcode, parse_record
from ur5_ros.cdr.codec import Definitions, definitions_of
from ur5_ros.cdr.message_definition import PRIMITIVES, parse_schema
from ur5_ros.cdr.recorded_types import DEFINITIONS
from ur5_ros.errors import BagError


class TopicInfo(NamedTuple):
    """One channel of a file."""

    name: str
    type: str
    encoding: str
    """Of the messages: ``cdr``."""
    schema_encoding: str
    schema: bytes
    qos: str
    """Offered QoS profiles, YAML."""
    type_hash: str

    def definitions(self) -> Definitions:
        """
        Return the definitions by which messages of this topic are read.

        Raises
        ------
        BagError
            If the encoding is not CDR, the schema cannot be read, or it defines a type that is
            recorded without the fields that ROS 2 gives it.

        """
        if self.encoding != 'cdr':
            way_out = _WAYS_OUT.get(self.encoding, 'record it as ROS 2 does')
            raise BagError(f'topic {self.name}: messages of type {self.type[:80]!r} encoded as '
                           f'{self.encoding[:20]!r}; only cdr is read: {way_out}')
        known = definitions_of(self.type) if self.type in DEFINITIONS else None
        if not self.type:
            raise BagError(f'topic {self.name}: the file does not state its type')
        if self.schema_encoding != 'ros2msg' or not self.schema.strip():
            if known is None:
                raise BagError(f'topic {self.name}: type {self.type[:80]!r} is defined in '
                               f'{self.schema_encoding[:20]!r}; only ros2msg is read')
            return known
        try:
            text = self.schema.decode()
        except UnicodeDecodeError:
            raise BagError(f'topic {self.name}: a schema that is not UTF-8') from None
        found = parse_schema(self.type, text)
        if known is not None:
            _refuse_other_fields(f'topic {self.name}: {self.type}', self.type, known, found)
        return found

    @property
    def is_ros2(self) -> bool:
        """Whether messages are as ROS 2 defines this type, as far as it is one of the recorded."""
        if self.type not in DEFINITIONS:
            return True
        try:
            found = self.definitions()
        except BagError:
            return False
        return all(found.get(name) == fields
                   for name, fields in definitions_of(self.type).items())


def _refuse_other_fields(where: str, type_name: str, known: Definitions,
                         found: Definitions) -> None:
    """
    Raise BagError where a schema gives a type other fields than ROS 2 does.

    More fields and bounds do no harm; of a type in ``NUMBERS`` its numbers may be of another kind,
    and all but the first may be missing.
    """
    for name, fields in known.items():
        theirs = {field.name: field for field in found.get(name, ())}
        numbers_of = NUMBERS.get(name, ()) if name == type_name else ()
        for field in fields:
            other = theirs.get(field.name)
            numbers = other is not None and field.name in numbers_of and (
                PRIMITIVES.get(other.base) is not None)
            same = other is not None and other.nested == field.nested and (
                bool(other.array) == bool(field.array)) and (numbers or other.base == field.base)
            if not same and (other is not None or field.name not in numbers_of[1:]):
                is_ = 'missing' if other is None else f'{other.base}{"[]" if other.array else ""}'
                raise BagError(f'{where} is defined otherwise than in ROS 2: its field '
                               f"{field.name} is {is_}; record it with ROS 2's own definition: "
                               'ros2 bag record')


#: Type -> its fields of numbers; a schema may leave out all but the first.
NUMBERS = {'sensor_msgs/msg/JointState': ('position', 'velocity', 'effort')}

#: Encoding of messages -> the way to one that is read.
_WAYS_OUT = {
    'ros1': 'it is a ROS 1 recording; convert it with: rosbags-convert, or mcap convert',
    'json': 'it is not a ROS 2 recording; record the ROS topics with: ros2 bag record',
}


def ros2_type(name: str, encoding: str) -> str:
    """Return a type as ``package/msg/Name``; others leave ``msg`` out, or write C++ or DDS."""
    if '::' in name:
        name = '/'.join(part for part in name.split('::') if part != 'dds_').rstrip('_')
    package, _, short = name.partition('/')
    return f'{package}/msg/{short}' if encoding == 'cdr' and short and '/' not in short else name


class FileDefinitions:
    """
    The schemas and channels that a file has defined so far.

    ``report`` takes a sentence about each contradiction; the first definition is kept.

    """

    def __init__(self, path: Path, report: Callable[[str], None]) -> None:
        self._path = path
        self._report = report
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self._topics: dict[int, TopicInfo] = {}
        self._stale = True

    def add(self, opcode: int, content: bytes) -> None:
        """Add a schema or channel record; BagError if it is damaged."""
        self._stale = True
        if opcode == Opcode.SCHEMA:
            schema = parse_record(Schema, content, str(self._path))
            if self.schemas.setdefault(schema.id, schema) != schema:
                self._report(f'{self._path}: defines schema {schema.id} twice, differently')
        else:
            channel = parse_record(Channel, content, str(self._path))
            if self.channels.setdefault(channel.id, channel) != channel:
                self._report(f'{self._path}: defines channel {channel.id} twice, differently')

    def topics(self) -> dict[int, TopicInfo]:
        """Return what is known of each channel."""
        if not self._stale:
            return self._topics
        self._topics, self._stale = {}, False
        for number, channel in self.channels.items():
            schema = self.schemas.get(channel.schema_id)
            form = schema.encoding if schema else ''
            encoding = channel.message_encoding.lower() or (
                'cdr' if form in ('', 'ros2msg', 'ros2idl') else '')
            self._topics[number] = TopicInfo(
                channel.topic, ros2_type(schema.name, encoding) if schema else '', encoding,
                form, schema.data if schema else b'',
                channel.metadata.get('offered_qos_profiles', ''),
                channel.metadata.get('topic_type_hash', ''))
        return self._topics

    def forget(self) -> None:
        """Drop all definitions: they came out of a damaged summary."""
        self.schemas.clear()
        self.channels.clear()
        self._stale = True
