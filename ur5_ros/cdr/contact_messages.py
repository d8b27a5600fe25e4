"""What is felt in a contact, as CDR bytes and back: wrench, force arrows, poses of bodies."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.cdr.codec import decode, encode
from ur5_ros.cdr.decoded import header_of, stamp_of
from ur5_ros.cdr.fixed_messages import FixedStamped, encode_stamp

#: Length of an arrow by the force that it stands for [m/N].
ARROW_SCALE = 0.01

_MARKERS, _POSES = 'visualization_msgs/msg/MarkerArray', 'geometry_msgs/msg/PoseArray'
_ARROW, _ADD, _DELETE_ALL = 0, 0, 3
#: Red, green and blue of the arrows: normal force, friction.
FORCE_COLOURS = ((230, 0, 92), (138, 154, 30))
_SHAFT, _HEAD = 0.008, 0.016


class ContactForce(NamedTuple):
    """The force of one contact, split into normal force and friction."""

    bodies: tuple[str, str]
    place: np.ndarray
    """In base [m], shape (3,)."""
    normal: np.ndarray
    """Part along the normal, on the first body [N], shape (3,)."""
    lateral: np.ndarray
    """Part across it [N], shape (3,)."""
    friction: float
    """Coefficient of the pair."""


class FixedWrench(FixedStamped):
    """geometry_msgs/WrenchStamped in one frame."""

    field, length = 'wrench', 6

    def encode(self, stamp: int, wrench: np.ndarray) -> bytes:
        """Return the message: stamp [ns], force [N] and torque [N m], shape (6,)."""
        return self.layout.fill(encode_stamp(stamp), np.asarray(wrench, '<f8').tobytes())


def encode_markers(stamp: int, frame_id: str, contacts: Sequence[ContactForce]) -> bytes:
    """
    Return the arrows of contacts as a visualization_msgs/MarkerArray.

    Two arrows a contact, blue the normal force and orange the friction, :data:`ARROW_SCALE` metres
    a newton, from the place of the contact; ``ns`` names the bodies, ``text`` the coefficient.

    """
    header = header_of(stamp, frame_id)
    markers = [_marker(header, _DELETE_ALL, '', 0, '', None, FORCE_COLOURS[0])]
    for i, each in enumerate(contacts):
        for j, force in enumerate((each.normal, each.lateral)):
            ends = np.array([each.place, each.place + ARROW_SCALE * force])
            markers.append(_marker(header, _ADD, ' / '.join(each.bodies), 2 * i + j,
                                   repr(each.friction), ends, FORCE_COLOURS[j]))
    return encode(_MARKERS, {'markers': markers})


def decode_markers(data: bytes) -> tuple[int, list[ContactForce]]:
    """Return stamp [ns] and contacts of what :func:`encode_markers` gave."""
    first, *arrows = decode(_MARKERS, data)['markers']
    found = []
    for normal, lateral in zip(arrows[::2], arrows[1::2], strict=True):
        place = _point(normal['points'][0])
        one, _, other = normal['ns'].partition(' / ')
        found.append(ContactForce(
            (one, other), place, (_point(normal['points'][1]) - place) / ARROW_SCALE,
            (_point(lateral['points'][1]) - place) / ARROW_SCALE, float(normal['text'])))
    return stamp_of(first['header']), found


def encode_poses(stamp: int, frame_id: str,
                 poses: Sequence[tuple[np.ndarray, np.ndarray]]) -> bytes:
    """Return positions [m] and quaternions (x, y, z, w) as a geometry_msgs/PoseArray."""
    return encode(_POSES, {'header': header_of(stamp, frame_id), 'poses': [
        {'position': dict(zip('xyz', map(float, place), strict=True)),
         'orientation': dict(zip('xyzw', map(float, turn), strict=True))}
        for place, turn in poses]})


def decode_poses(data: bytes) -> tuple[int, np.ndarray]:
    """Return stamp [ns] and positions and quaternions, shape (n, 7), of a PoseArray."""
    message = decode(_POSES, data)
    rows = [[*(pose['position'][axis] for axis in 'xyz'),
             *(pose['orientation'][axis] for axis in 'xyzw')] for pose in message['poses']]
    return stamp_of(message['header']), np.array(rows, dtype=float).reshape(-1, 7)


def _marker(header: dict[str, Any], action: int, ns: str, number: int, text: str,
            ends: np.ndarray | None, colour: tuple[int, int, int]) -> dict[str, Any]:
    rgba = [*(share / 255 for share in colour), 1.0]
    points = [] if ends is None else [dict(zip('xyz', end, strict=True)) for end in ends.tolist()]
    return {'header': header, 'ns': ns, 'id': number, 'type': _ARROW, 'action': action,
            'pose': {'orientation': {'w': 1.0}}, 'scale': {'x': _SHAFT, 'y': _HEAD, 'z': _HEAD},
            'color': dict(zip('rgba', rgba, strict=True)), 'points': points, 'text': text}


def _point(point: dict[str, float]) -> np.ndarray:
    return np.array([point['x'], point['y'], point['z']])
