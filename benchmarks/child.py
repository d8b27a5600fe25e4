"""Processes of a benchmark: each ends with it, however it ends."""

import signal
import subprocess
from functools import partial
from typing import Any

from ur5_ros.launcher.signals import end_with_parent

_end = partial(end_with_parent, signal.SIGKILL)


def start(command: list[str], **options: Any) -> subprocess.Popen:
    """Start a process; ``options`` are those of :class:`subprocess.Popen`."""
    return subprocess.Popen(command, preexec_fn=_end, **options)


def call(command: list[str], **options: Any) -> subprocess.CompletedProcess:
    """Run a process, which has to end with code 0."""
    return subprocess.run(command, check=True, preexec_fn=_end, **options)
