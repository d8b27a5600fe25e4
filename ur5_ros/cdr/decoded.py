"""Parts that several messages share, as the dictionaries of :mod:`ur5_ros.cdr.codec` hold them."""

from typing import Any


def header_of(stamp: int, frame_id: str = '') -> dict[str, Any]:
    """Return a std_msgs/Header with a stamp [ns]."""
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    return {'stamp': {'sec': seconds, 'nanosec': nanoseconds}, 'frame_id': frame_id}


def stamp_of(header: dict[str, Any]) -> int:
    """Return the stamp of a std_msgs/Header [ns]."""
    return int(header['stamp']['sec']) * 1_000_000_000 + int(header['stamp']['nanosec'])


def force_and_torque(wrench: dict[str, Any]) -> tuple[list[float], list[float]]:
    """Return force [N] and torque [N m] of a geometry_msgs/Wrench."""
    force, torque = ([wrench[part][axis] for axis in 'xyz'] for part in ('force', 'torque'))
    return force, torque
