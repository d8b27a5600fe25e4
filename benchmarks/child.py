"""Processes of a benchmark: each ends with it, however it ends."""

import os
import signal
import subprocess
from functools import partial
from typing import Any

from ur5_ros.launcher.signals import end_with_parent

# as the Makefile does: what is started keeps what Python compiles, as it does where users start it
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
_end = partial(end_with_parent, signal.SIGKILL)


def start(command: list[str], **options: Any) -> subprocess.Popen:
    """Start a process; ``options`` are those of :class:`subprocess.Popen`."""
    return subprocess.Popen(command, preexec_fn=_end, **options)


def call(command: list[str], **options: Any) -> subprocess.CompletedProcess:
    """Run a process, which has to end with code 0."""
    return subprocess.run(command, check=True, preexec_fn=_end, **options)
