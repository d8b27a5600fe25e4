"""diagnostic_msgs/DiagnosticArray with one status: the form of events and diagnostics."""

from collections.abc import Mapping
from typing import Any

from ur5_ros.cdr.codec import encode
from ur5_ros.cdr.decoded import header_of

OK, WARN, ERROR, STALE = range(4)


def status_array(
    stamp: int, name: str, message: str, hardware_id: str, values: Mapping[str, Any],
    level: int = OK,
) -> bytes:
    """
    Return diagnostic_msgs/DiagnosticArray with one status, as CDR bytes.

    ``stamp``: header stamp [ns]; ``level``: ``OK``, ``WARN``, ``ERROR`` or ``STALE``.
    """
    return encode('diagnostic_msgs/msg/DiagnosticArray', {
        'header': header_of(stamp),
        'status': [{
            'level': level, 'name': name, 'message': message, 'hardware_id': hardware_id,
            'values': [{'key': key, 'value': str(value)} for key, value in values.items()],
        }],
    })
