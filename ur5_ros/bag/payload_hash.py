"""One hash for all payloads of a topic: equal for equal runs, whatever the padding holds."""

import hashlib

import numpy as np

from ur5_ros.cdr.fixed_messages import FixedJointState

#: Messages that are hashed at once: one by one costs ten times as much.
_BATCH = 512


class PayloadHash:
    """SHA-256 over stamp (int64, ns) and float64 fields of JointState, little-endian."""

    def __init__(self, layout: FixedJointState) -> None:
        fields = {name: (f'({number},){kind}', offset)
                  for name, (offset, kind, number) in layout.layout.slots.items()}
        self._type = np.dtype({
            'names': list(fields), 'formats': [form for form, _ in fields.values()],
            'offsets': [offset for _, offset in fields.values()], 'itemsize': layout.size})
        self._doubles = [name for name in fields if name != 'stamp']
        self._waiting: list[bytes] = []
        self._sha = hashlib.sha256()
        self.count = 0
        """Messages hashed."""

    def add(self, data: bytes) -> None:
        """Add a message."""
        self._waiting.append(data)
        self.count += 1
        if len(self._waiting) >= _BATCH:
            self._hash()

    def hexdigest(self) -> str:
        """Return the hash of all messages so far."""
        self._hash()
        return self._sha.hexdigest()

    def _hash(self) -> None:
        if not self._waiting:
            return
        messages = np.frombuffer(b''.join(self._waiting), self._type)
        self._waiting.clear()
        stamp = messages['stamp'].astype(np.int64) @ np.array([1_000_000_000, 1])
        rows = [stamp.astype('<i8')[:, None].view('<f8')]
        rows += [messages[name] for name in self._doubles]
        self._sha.update(np.hstack(rows).tobytes())
