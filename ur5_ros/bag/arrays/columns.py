"""Messages of one topic as arrays, and which types of message have that form."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.cdr.fixed_messages import FixedJointState, FixedPose, FixedTrajectoryPoint
from ur5_ros.cdr.layout import Layout


class RawColumns(NamedTuple):
    """The messages of one topic as bytes, as the bag holds them."""

    log_time: np.ndarray
    """[ns], int64, shape (n,)."""
    publish_time: np.ndarray
    """[ns], int64, shape (n,)."""
    data: np.ndarray
    """CDR bytes of all messages, one after the other, uint8."""
    offsets: np.ndarray
    """Message i is ``data[offsets[i]:offsets[i + 1]]``; int64, shape (n + 1,)."""


class Columns(NamedTuple):
    """The numbers of one topic."""

    names: tuple[str, ...]
    """Names of the columns of each field: joint names, or the coordinates of a pose."""
    stamp: np.ndarray
    """Header stamps [ns], int64, shape (n,)."""
    log_time: np.ndarray
    """[ns], int64, shape (n,)."""
    publish_time: np.ndarray
    """[ns], int64, shape (n,)."""
    fields: dict[str, np.ndarray]
    """Field -> float64, shape (n, len(names)); NaN where a message leaves the field empty."""
    skipped: int
    """Messages left out: without one of the names, or with lengths that contradict each other."""
    broken: np.ndarray = np.zeros(0, np.int64)
    """Log times [ns] of those of them that are empty or contradict themselves."""
    short: dict[str, int] = {}
    """Field -> messages that have fewer values of it than names, where it is NaN."""

    def __getattr__(self, name: str) -> np.ndarray:
        """Return a field by its name, such as ``position``."""
        try:
            return self.fields[name]
        except KeyError:
            known = ', '.join(self.fields)
            raise AttributeError(f'no field {name!r}; there are {known}') from None


class MessageKind(NamedTuple):
    """How messages of one type become columns."""

    fields: tuple[str, ...]
    names: Callable[[dict[str, Any]], Sequence[str]]
    """Names of the columns of a message."""
    values: Callable[[dict[str, Any]], dict[str, np.ndarray]]
    """Numbers of a message, field by field."""
    layout: Callable[[Sequence[str], str, Sequence[str]], Layout]
    """Layout from names, frame and the fields that are filled."""


def _point(message: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the only point of a trajectory."""
    return message['points'][0] if len(message['points']) == 1 else {}


def _pose(message: dict[str, Any]) -> dict[str, np.ndarray]:
    position, turn = message['pose']['position'], message['pose']['orientation']
    return {'pose': np.array([*position.values(), *turn.values()])}


POSE_NAMES = ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')

#: The types that become columns.
COLUMN_TYPES = {
    'sensor_msgs/msg/JointState': MessageKind(
        ('position', 'velocity', 'effort'), lambda message: message['name'],
        lambda message: message,
        lambda names, frame, fields: FixedJointState(names, frame, fields).layout),
    'trajectory_msgs/msg/JointTrajectory': MessageKind(
        FixedTrajectoryPoint.FIELDS, lambda message: message['joint_names'], _point,
        lambda names, frame, fields: FixedTrajectoryPoint(names, frame, fields).layout),
    'geometry_msgs/msg/PoseStamped': MessageKind(
        ('pose',), lambda message: POSE_NAMES, _pose,
        lambda names, frame, fields: FixedPose(frame).layout),
}
