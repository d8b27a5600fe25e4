"""Schemas and channels of an MCAP file: the types of its messages."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Schema

from ur5_ros.bag.mcap.records import Opcode, parse_record
from ur5_ros.cdr.codec import Definitions, definitions_of
from ur5_ros.cdr.message_definition import parse_schema
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
            recorded otherwise than ROS 2 does.

        """
        if self.encoding != 'cdr':
            raise BagError(f'topic {self.name}: messages encoded as {self.encoding[:20]!r}; '
                           'only cdr is read')
        known = definitions_of(self.type) if self.type in DEFINITIONS else None
        if self.schema_encoding != 'ros2msg':
            if known is None:
                raise BagError(f'topic {self.name}: type {self.type[:80]!r} is defined in '
                               f'{self.schema_encoding[:20]!r}; only ros2msg is read')
            return known
        try:
            text = self.schema.decode()
        except UnicodeDecodeError:
            raise BagError(f'topic {self.name}: a schema that is not UTF-8') from None
        found = parse_schema(self.type, text)
        if known is not None and any(found.get(name) != fields for name, fields in known.items()):
            raise BagError(f'topic {self.name}: {self.type} is defined otherwise than in ROS 2')
        return found


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
            self._topics[number] = TopicInfo(
                channel.topic, schema.name if schema else '', channel.message_encoding,
                schema.encoding if schema else '', schema.data if schema else b'',
                channel.metadata.get('offered_qos_profiles', ''),
                channel.metadata.get('topic_type_hash', ''))
        return self._topics

    def forget(self) -> None:
        """Drop all definitions: they came out of a damaged summary."""
        self.schemas.clear()
        self.channels.clear()
        self._stale = True
