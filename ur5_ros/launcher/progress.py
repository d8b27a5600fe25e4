"""How far a recording has come, read from the growing file without decompressing it."""

import struct
from collections import Counter
from pathlib import Path

_MAGIC = 8
_HEAD = struct.Struct('<BQ')  # opcode, length of the content
_INDEX = struct.Struct('<HI')  # channel, bytes of the entries
_MESSAGE_INDEX = 0x07
_ENTRY = 16  # log time and offset


class BagGrowth:
    """
    Counts messages in the MCAP files of a folder while they are being written.

    Each chunk is followed by an index a channel (MCAP specification, Message Index), whose length
    alone gives the number of messages.

    ``folder``: bag folder; it need not exist yet.

    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._offsets: dict[Path, int] = {}
        self._counts: dict[Path, Counter] = {}

    def messages(self) -> int:
        """Return how many messages the busiest topic has so far."""
        total: Counter = Counter()
        for path in sorted(self.folder.glob('*.mcap')):
            self._read_on(path)
            total.update(self._counts[path])
        return max(total.values(), default=0)

    def _read_on(self, path: Path) -> None:
        offset = self._offsets.setdefault(path, _MAGIC)
        counts = self._counts.setdefault(path, Counter())
        size = path.stat().st_size
        with open(path, 'rb') as file:
            while offset + _HEAD.size <= size:
                file.seek(offset)
                opcode, length = _HEAD.unpack(file.read(_HEAD.size))
                if offset + _HEAD.size + length > size:
                    break
                if opcode == _MESSAGE_INDEX and length >= _INDEX.size:
                    channel, entries = _INDEX.unpack(file.read(_INDEX.size))
                    counts[channel] += entries // _ENTRY
                offset += _HEAD.size + length
        self._offsets[path] = offset
