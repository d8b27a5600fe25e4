"""
Starts nodes by fork: what they import, most of their start, is imported once for all tests.

As a program it takes a request a line, forks, and reports ids and exit codes; :class:`Starter`
is its other end.  Each node is a process as always, with the middleware, files, signals and
environment of its own; tests of the start itself have no use for it.
"""

import gc
import importlib
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

#: What the executables import when they run.
LOADED = ('ur5_ros.nodes.ros.process', 'ur5_ros.nodes.composition')


class Forked:
    """A node that was forked; used like :class:`subprocess.Popen`."""

    def __init__(self, pid: int, codes: dict[int, int]) -> None:
        self.pid, self._codes = pid, codes

    def poll(self) -> int | None:
        """Return the exit code, None while it runs."""
        return self._codes.get(self.pid)

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code at the end."""
        end = None if timeout is None else time.monotonic() + timeout
        while self.poll() is None:
            if end is not None and time.monotonic() > end:
                raise subprocess.TimeoutExpired(f'node {self.pid}', timeout or 0.0)
            time.sleep(0.005)
        return self._codes[self.pid]

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            with suppress(ProcessLookupError):  # ended, and its exit code is on its way
                os.kill(self.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


class Starter:
    """The process that forks, and what it reports."""

    def __init__(self) -> None:
        self._codes: dict[int, int] = {}
        self._started: list[int] = []
        self._process = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=os.environ | {'OPENBLAS_NUM_THREADS': '1'})  # as the nodes choose it
        threading.Thread(target=self._read, daemon=True).start()

    def start(self, module: str, arguments: list[str], folder: Path, log: Path,
              environment: Mapping[str, str]) -> Forked:
        """Start ``python -m module``, its output going to a file."""
        already = len(self._started)
        self._process.stdin.write(json.dumps(
            [module, arguments, str(folder), str(log), dict(environment)]) + '\n')
        self._process.stdin.flush()
        while len(self._started) == already:
            assert self._process.poll() is None, 'the process that starts nodes has ended'
            time.sleep(0.001)
        return Forked(self._started[-1], self._codes)

    def _read(self) -> None:
        for line in self._process.stdout:
            what, pid, code = line.split()
            if what == 'started':
                self._started.append(int(pid))
            else:
                self._codes[int(pid)] = int(code)


def main() -> None:
    """Fork a node for each request until there are no more."""
    for module in LOADED:
        importlib.import_module(module)
    # two of LTTng's wait for a tracer, which there is none of; nodes would lack any other
    assert len(os.listdir('/proc/self/task')) <= 3, 'a process with threads cannot be forked'
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the tests
    readable, writable = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(writable)
    rest = b''
    while True:
        ready, _, _ = select.select([0, readable], [], [])
        if readable in ready:
            os.read(readable, 1024)
            report_ends()
        if 0 in ready:
            data = os.read(0, 1 << 16)
            if not data:
                return
            *requests, rest = (rest + data).split(b'\n')
            for request in requests:
                pid = os.fork()
                if pid == 0:
                    become(*json.loads(request))
                print('started', pid, 0, flush=True)


def report_ends() -> None:
    """Report the children that have ended."""
    while True:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return
        if pid == 0:
            return
        print('ended', pid, os.waitstatus_to_exitcode(status), flush=True)


def become(module: str, arguments: list[str], folder: str, log: str,
           environment: dict[str, str]) -> None:
    """Be the node; never return."""
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for number, path, flags in ((0, os.devnull, os.O_RDONLY),
                                    (1, log, os.O_WRONLY | os.O_APPEND)):
            file = os.open(path, flags)
            os.dup2(file, number)
            os.close(file)
        os.dup2(1, 2)
        sys.stdout = open(1, 'w', buffering=1, closefd=False)  # noqa: SIM115
        sys.stderr = open(2, 'w', buffering=1, closefd=False)  # noqa: SIM115
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        loaded = importlib.import_module(module)
        sys.argv = [loaded.__file__, *arguments]
        loaded.main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == '__main__':
    main()
