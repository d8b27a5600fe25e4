"""What a program writes to a terminal: a child on a pseudo-terminal, ended whatever happens."""

import contextlib
import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
from pathlib import Path
from typing import Any

COMMAND = 'from ur5_ros.cli import main; main()'


def written(*arguments: Any, script: str = COMMAND, folder: Path | None = None,
            columns: int = 80, seconds: float = 120.0, **variables: str) -> str:
    """Return what a command line of ``ur5``, or a script, writes to a terminal of this width."""
    environment = {key: value for key, value in os.environ.items()
                   if key not in ('COLUMNS', 'LINES', 'NO_COLOR', 'FORCE_COLOR', 'CI')}
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack('HHHH', 40, columns, 0, 0))
    child = subprocess.Popen(
        [sys.executable, '-c', script, *map(str, arguments)], stdin=terminal, stdout=terminal,
        stderr=terminal, cwd=folder, env={**environment, 'TERM': 'xterm', **variables})
    os.close(terminal)
    printed = b''
    try:
        with contextlib.suppress(OSError):  # the other end is closed
            while part := os.read(reader, 10_000):
                printed += part
        child.wait(seconds)
    finally:
        os.close(reader)
        if child.poll() is None:
            child.kill()
            child.wait()
    return printed.decode()
