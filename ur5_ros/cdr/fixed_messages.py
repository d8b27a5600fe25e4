"""
Messages as CDR bytes.

Those of the control loop have a fixed layout: the numbers are at known offsets, the rest never
changes. For all others :func:`encode` and :func:`decode` follow the message definition.
"""

from collections.abc import Sequence
from struct import Struct

import numpy as np

from ur5_ros.cdr.codec import decode, encode
from ur5_ros.cdr.layout import LITTLE_ENDIAN, Layout

__all__ = ['FixedJointState', 'FixedPose', 'FixedTrajectoryPoint', 'decode',
           'decode_clock', 'encode', 'encode_clock', 'encode_string']

NANOSECONDS = 1_000_000_000

_FLOAT = np.dtype(np.float64)
_frombuffer = np.frombuffer
_stamp = Struct('<iI')
_pack_stamp = _stamp.pack
_AT_ONCE = bytes(8)  # builtin_interfaces/Duration


def _stamp_from(data: bytes) -> int:
    """Return the stamp [ns] at the start of a message, as written without its range checked."""
    seconds, nanoseconds = _stamp.unpack_from(data, 4)
    return seconds * NANOSECONDS + nanoseconds


def _doubles(values: Sequence[float] | np.ndarray) -> bytes:
    """Return float64 little-endian bytes."""
    if type(values) is np.ndarray and values.dtype is _FLOAT:
        return values.tobytes()
    return np.asarray(values, _FLOAT).tobytes() if len(values) else b''


def _check(counts: dict[str, int], *given: bytes) -> None:
    """Refuse fields that have another number of values than the layout."""
    for (name, number), data in zip(counts.items(), given, strict=True):
        if len(data) != 8 * number:
            raise ValueError(f'{name} has {len(data) // 8} numbers; this layout has {number}')


class FixedJointState:
    """
    sensor_msgs/JointState with names that do not change: one microsecond instead of twenty.

    ``fields``: which of position, velocity and effort are filled; the others are empty sequences.

    """

    def __init__(self, names: Sequence[str], frame_id: str = '',
                 fields: Sequence[str] = ('position', 'velocity', 'effort')) -> None:
        self.names = tuple(names)
        self._counts = {field: len(self.names) if field in fields else 0
                        for field in ('position', 'velocity', 'effort')}
        layout = Layout()
        layout.slot('stamp', '<u4', 2)
        layout.text(frame_id)
        layout.texts(self.names)
        for field, number in self._counts.items():
            layout.doubles(field, number)
        self.layout = layout.close()
        self.size = layout.size
        """Length of a message in bytes: 316 for the six joints of the UR arms."""
        self.matches = layout.matches
        self._fill = layout.fill
        self._sizes = tuple(8 * number for number in self._counts.values())
        self._places = [(layout.slots.get(field, (0,))[0], number)
                        for field, number in self._counts.items()]

    def encode(self, stamp: int, position=(), velocity=(), effort=()) -> bytes:
        """
        Return the message as CDR bytes, padding zero.

        ``stamp``: header stamp [ns]; ``position``, ``velocity``, ``effort`` (n,): [rad], [rad/s],
        [N m]; empty for the fields that this layout leaves out.
        """
        q, qd, tau = _doubles(position), _doubles(velocity), _doubles(effort)
        if (len(q), len(qd), len(tau)) != self._sizes:
            _check(self._counts, q, qd, tau)
        return self._fill(_pack_stamp(*divmod(stamp, NANOSECONDS)), q, qd, tau)

    def join(self, stamp: bytes, position: bytes, velocity: bytes, effort: bytes) -> bytes:
        """Return the same of parts that are CDR bytes already, of the right lengths."""
        return self._fill(stamp, position, velocity, effort)

    def decode(self, data: bytes) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
        """
        Return (stamp [ns], position, velocity, effort) of a message that :meth:`matches`.

        The arrays are read-only views of ``data``; a field left out is an empty array.
        """
        (a, i), (b, j), (c, k) = self._places
        seconds, nanoseconds = _stamp.unpack_from(data, 4)
        return (seconds * NANOSECONDS + nanoseconds, _frombuffer(data, _FLOAT, i, a),
                _frombuffer(data, _FLOAT, j, b), _frombuffer(data, _FLOAT, k, c))

    def stamp_and_effort(self, data: bytes) -> tuple[int, np.ndarray]:
        """Return the stamp [ns] and the efforts, read-only, of a message that :meth:`matches`."""
        offset, number = self._places[-1]
        return _stamp_from(data), _frombuffer(data, _FLOAT, number, offset)


class FixedTrajectoryPoint:
    """
    trajectory_msgs/JointTrajectory with one full point, as ``~/reference`` is published.

    ``fields``: which of FIELDS are filled; the others are empty sequences.

    """

    FIELDS = ('positions', 'velocities', 'accelerations', 'effort')

    def __init__(self, names: Sequence[str], frame_id: str = '',
                 fields: Sequence[str] = FIELDS) -> None:
        self.names = tuple(names)
        self._counts = {field: len(self.names) if field in fields else 0 for field in self.FIELDS}
        layout = Layout()
        layout.slot('stamp', '<u4', 2)
        layout.text(frame_id)
        layout.texts(self.names)
        layout.count(1)
        for field, number in self._counts.items():
            layout.doubles(field, number)
        layout.slot('time_from_start', '<u4', 2)
        self.layout = layout.close()
        self.size = layout.size
        self.matches = layout.matches
        self._fill = layout.fill
        self._sizes = tuple(8 * number for number in self._counts.values())

    def encode(self, stamp: int, positions=(), velocities=(), accelerations=(),
               effort=()) -> bytes:
        """Return the message as CDR bytes; stamp [ns], four arrays of shape (n,), SI units."""
        q, qd, qdd, tau = (_doubles(positions), _doubles(velocities), _doubles(accelerations),
                           _doubles(effort))
        if (len(q), len(qd), len(qdd), len(tau)) != self._sizes:
            _check(self._counts, q, qd, qdd, tau)
        return self._fill(_pack_stamp(*divmod(stamp, NANOSECONDS)), q, qd, qdd, tau, _AT_ONCE)

    def join(self, stamp: bytes, positions: bytes, velocities: bytes, accelerations: bytes,
             effort: bytes) -> bytes:
        """Return the same of parts that are CDR bytes already, of the right lengths."""
        return self._fill(stamp, positions, velocities, accelerations, effort, _AT_ONCE)

    def decode(self, data: bytes) -> tuple[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (stamp [ns], positions, velocities, accelerations, effort), read-only views."""
        arrays = [np.frombuffer(data, _FLOAT, number, self.layout.slots.get(name, (0,))[0])
                  for name, number in self._counts.items()]
        q, qd, qdd, tau = arrays
        return _stamp_from(data), q, qd, qdd, tau


class FixedStamped:
    """A message of geometry_msgs: a header in one frame, and numbers."""

    #: Name and length of the numbers.
    field, length = '', 0

    def __init__(self, frame_id: str) -> None:
        layout = Layout()
        layout.slot('stamp', '<u4', 2)
        layout.text(frame_id)
        layout.slot(self.field, '<f8', self.length)
        self.layout = layout.close()
        self.size = layout.size
        self.matches = layout.matches


class FixedPose(FixedStamped):
    """geometry_msgs/PoseStamped in one frame."""

    field, length = 'pose', 7

    def encode(self, stamp: int, position, quaternion) -> bytes:
        """Return the message: stamp [ns], position (3,) [m], quaternion (4,) as x, y, z, w."""
        given = (_doubles(position), _doubles(quaternion))
        _check({'position': 3, 'quaternion': 4}, *given)
        return self.layout.fill(encode_stamp(stamp), b''.join(given))

    def decode(self, data: bytes) -> tuple[int, np.ndarray, np.ndarray]:
        """Return (stamp [ns], position (3,), quaternion (4,) as x, y, z, w), read-only views."""
        offset = self.layout.slots['pose'][0]
        return (_stamp_from(data), np.frombuffer(data, '<f8', 3, offset),
                np.frombuffer(data, '<f8', 4, offset + 24))


def encode_stamp(stamp: int) -> bytes:
    """Return builtin_interfaces/Time of a stamp [ns] as CDR bytes."""
    return _pack_stamp(*divmod(stamp, NANOSECONDS))


def encode_clock(stamp: int) -> bytes:
    """Return rosgraph_msgs/Clock of a stamp [ns] as CDR bytes."""
    return LITTLE_ENDIAN + encode_stamp(stamp)


def decode_clock(data: bytes) -> int:
    """Return the stamp [ns] of a rosgraph_msgs/Clock."""
    if len(data) != 12 or data[:2] != LITTLE_ENDIAN[:2]:
        raise ValueError(f'{len(data)} bytes are no little-endian rosgraph_msgs/Clock')
    return _stamp_from(data)


def encode_string(text: str) -> bytes:
    """Return std_msgs/String as CDR bytes."""
    data = text.encode() + b'\0'
    return LITTLE_ENDIAN + len(data).to_bytes(4, 'little') + data


def encode_number(number: float) -> bytes:
    """Return std_msgs/Float64 as CDR bytes."""
    return LITTLE_ENDIAN + Struct('<d').pack(number)
