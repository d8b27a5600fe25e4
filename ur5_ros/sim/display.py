"""Is there a screen? PyBullet ends the whole process when it asks and there is none."""

import os
import socket
import sys

from ur5_ros.errors import InputError

_UNIX = '/tmp/.X11-unix/X'


def check_display() -> None:
    """Return if PyBullet's window can open."""
    if not sys.platform.startswith('linux'):
        return
    display = os.environ.get('DISPLAY', '')
    host, _, number = display.rpartition(':')
    number = number.partition('.')[0]
    if not number.isdigit():
        raise InputError(f'gui is true and DISPLAY is {display!r}: no screen; set gui to false')
    if host in ('', 'unix'):
        found = any(_reaches(socket.AF_UNIX, start + _UNIX + number) for start in ('', '\0'))
    else:
        found = _reaches(socket.AF_INET, (host, 6000 + int(number)))
    if not found:
        raise InputError(f'gui is true and the screen {display} does not answer; set gui to false')


def _reaches(family: int, address: str | tuple[str, int]) -> bool:
    with socket.socket(family, socket.SOCK_STREAM) as end:
        end.settimeout(2.0)
        try:
            end.connect(address)
        except (OSError, OverflowError):
            return False
    return True
