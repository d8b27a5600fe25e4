"""Records of the MCAP format (mcap.dev/spec): limits, framing, parsing."""

import zlib
from collections.abc import Mapping
from io import BytesIO
from struct import Struct
from struct import error as StructError
from typing import Any

import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import McapRecord

from ur5_ros.errors import BagError

MAGIC = b'\x89MCAP0\r\n'

#: Largest record, and largest chunk once decompressed, that is read [bytes]. rosbag2 cuts chunks
#: at 768 KiB, mcap at 1 MiB.
MAX_RECORD = 64 << 20

#: Opcode and length, in front of every record.
FRAME = Struct('<BQ')

#: A whole message record up to its data.
MESSAGE = Struct('<BQHIQQ')
MESSAGE_HEAD = np.dtype([('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'),
                         ('sequence', '<u4'), ('log_time', '<u8'), ('publish_time', '<u8')])
#: Length that a message record has beyond its data.
MESSAGE_EXTRA = MESSAGE.size - FRAME.size

INDEX_ENTRY = np.dtype([('log_time', '<u8'), ('offset', '<u8')])


def record_bytes(*records: McapRecord) -> bytes:
    """Return records as bytes, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


class _ExactStream(ReadDataStream):
    """Fails where less is left than a record asks for, instead of giving what there is."""

    def read(self, length: int) -> bytes:
        """Return the next bytes, all of them."""
        data = super().read(length)
        if len(data) != length:
            raise EndOfFile()
        return data


def parse_record(kind: Any, content: bytes, source: str) -> Any:
    """
    Return a record of the mcap package from its content (without opcode and length).

    BagError if the content is too short or too long, or holds text that is not UTF-8.

    """
    stream = _ExactStream(BytesIO(content))
    try:
        record = kind.read(stream)
    except (McapError, StructError, UnicodeDecodeError, ValueError, OverflowError, MemoryError):
        raise BagError(f'{source}: a damaged {kind.__name__} record') from None
    if stream.count != len(content):
        raise BagError(f'{source}: a damaged {kind.__name__} record')
    return record


#: Key of the checksum in this package's metadata records.
CHECKSUM = 'ur5_ros/crc32'


def checked(name: str, values: Mapping[str, str]) -> dict[str, str]:
    """Return the content of a metadata record with a checksum: MCAP keeps none for these."""
    return {**values, CHECKSUM: checksum(name, values)}


def checksum(name: str, values: Mapping[str, str]) -> str:
    """Return the CRC-32 of a metadata record in hexadecimal digits, the order of keys ignored."""
    items = sorted(item for item in values.items() if item[0] != CHECKSUM)
    text = '\0'.join((name, *(part for item in items for part in item)))
    return f'{zlib.crc32(text.encode()):08x}'


__all__ = ['CHECKSUM', 'FRAME', 'INDEX_ENTRY', 'MAGIC', 'MAX_RECORD', 'MESSAGE', 'MESSAGE_EXTRA',
           'MESSAGE_HEAD', 'Opcode', 'checked', 'checksum', 'parse_record', 'record_bytes']
