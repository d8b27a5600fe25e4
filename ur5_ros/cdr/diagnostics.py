"""diagnostic_msgs/DiagnosticArray with one status: the form of events and diagnostics."""

from collections.abc import Mapping
from typing import Any

from ur5_ros.cdr.codec import encode

OK, WARN, ERROR, STALE = range(4)


def status_array(
    stamp: int, name: str, message: str, hardware_id: str, values: Mapping[str, Any],
    level: int = OK,
) -> bytes:
    """
    Return diagnostic_msgs/DiagnosticArray with one status, as CDR bytes.

    ``stamp``: header stamp [ns]; ``level``: ``OK``, ``WARN``, ``ERROR`` or ``STALE``.
    """
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    return encode('diagnostic_msgs/msg/DiagnosticArray', {
        'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds}, 'frame_id': ''},
        'status': [{
            'level': level, 'name': name, 'message': message, 'hardware_id': hardware_id,
            'values': [{'key': key, 'value': str(value)} for key, value in values.items()],
        }],
    })
