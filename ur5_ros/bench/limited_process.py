"""Code of a user in its own process, with limited time and memory; no guard against malice."""

import json
import os
import resource
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

#: Memory beyond what the package itself takes [bytes].
MEMORY = 512 * 2**20


class Outcome(NamedTuple):
    """How a limited process ended."""

    result: Any
    """What it wrote; None if it did not come to that."""
    why: str
    """In one line why there is no result; empty if there is one."""


def run_limited(module: str, arguments: list[str], seconds: float) -> Outcome:
    """
    Run a module of the package as ``python -m MODULE RESULT_FILE ARGUMENTS``.

    Parameters
    ----------
    module : str
        Its main calls :func:`limit_memory` and writes its result with :func:`write_result`.
    arguments : list of str
        Further arguments.
    seconds : float
        Wall-clock time after which the process and its children are ended.

    """
    with TemporaryDirectory(prefix='ur5-limited-') as folder:
        file = Path(folder) / 'result.json'
        threads = dict.fromkeys(('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS'), '1')
        process = subprocess.Popen(
            [sys.executable, '-m', module, str(file), *arguments], stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True,
            env={**os.environ, **threads})
        try:
            _, errors = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            return Outcome(None, f'no result after {seconds:g} s; an endless loop?')
        finally:
            _end(process)
        if file.is_file():
            return Outcome(json.loads(file.read_text(encoding='utf-8')), '')
        return Outcome(None, _reason(process.returncode, errors.decode(errors='replace')))


def limit_memory() -> None:
    """Let this process take :data:`MEMORY` more than it has now."""
    status = Path('/proc/self/status').read_text(encoding='ascii')
    now = next(int(line.split()[1]) for line in status.splitlines() if line.startswith('VmData'))
    resource.setrlimit(resource.RLIMIT_DATA, (1024 * now + MEMORY, resource.RLIM_INFINITY))


def write_result(file: str, result: Any) -> None:
    """Write what the parent reads, whole or not at all."""
    unfinished = Path(file + '.unfinished')
    unfinished.write_text(json.dumps(result), encoding='utf-8')
    os.replace(unfinished, file)


def _end(process: subprocess.Popen) -> None:
    """End the process with all of its children, which share its session."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def _reason(code: int | None, errors: str) -> str:
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    if code is not None and code < 0:
        return f'the process was ended by signal {-code} ({signal.Signals(-code).name})'
    last = lines[-1][:200] if lines else ''
    return f'the process ended with code {code}' + (f': {last}' if last else '')
