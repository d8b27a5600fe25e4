"""Code of a user in its own process, with limited time and memory; no guard against malice."""

import json
import os
import resource
import signal
import subprocess
import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, NoReturn

from ur5_ros.launcher.signals import end_with_parent

#: Memory beyond what the package itself takes, and length of a file that is written [bytes].
MEMORY, FILE_SIZE = 512 * 2**20, 64 * 2**20
OUT_OF_MEMORY = 'more than 512 MB of memory'
#: How much of what the process printed last is looked at [bytes].
_TAIL = 16_384


class Outcome(NamedTuple):
    """How a limited process ended."""

    result: Any
    """What it wrote; None if it did not come to that."""
    why: str
    """In one line why there is no result; empty if there is one."""
    late: bool = False
    """Whether its time was over."""


def run_limited(module: str, arguments: list[str], seconds: float,
                folder: Path | None = None) -> Outcome:
    """
    Run a module of the package as ``python -P -m MODULE RESULT_FILE ARGUMENTS``.

    What it prints is kept off the screen; what it starts ends with it, and it with this process.

    ``folder``: where it works; a folder that goes with it if not given.
    """
    with TemporaryDirectory(prefix='ur5-limited-', ignore_cleanup_errors=True) as temporary:
        file, errors = Path(temporary) / 'result.json', Path(temporary) / 'errors'
        work = Path(temporary) / 'work'
        work.mkdir()
        quiet = {'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1',
                 'PYTHONDONTWRITEBYTECODE': '1'}
        with errors.open('wb') as sink:
            process = subprocess.Popen(
                [sys.executable, '-P', '-m', module, str(file), *arguments],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=sink,
                start_new_session=True, preexec_fn=partial(end_with_parent, signal.SIGKILL),
                cwd=folder or work, env={**os.environ, **quiet})
        try:
            process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            return Outcome(None, f'no result after {seconds:g} s; an endless loop?', late=True)
        finally:
            _end(process)
        if file.is_file():
            return Outcome(json.loads(file.read_text(encoding='utf-8')), '')
        return Outcome(None, _reason(process.returncode, errors))


def limit_resources() -> None:
    """Let this process take :data:`MEMORY` more than it has now, and write no endless file."""
    status = Path('/proc/self/status').read_text(encoding='ascii')
    now = next(int(line.split()[1]) for line in status.splitlines() if line.startswith('VmData'))
    for what, limit in ((resource.RLIMIT_DATA, 1024 * now + MEMORY),
                        (resource.RLIMIT_FSIZE, FILE_SIZE), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(what, (limit, resource.getrlimit(what)[1]))


def end_with(file: str, result: Any) -> NoReturn:
    """Write what the parent reads, whole or not at all, and end whatever threads go on."""
    unfinished = Path(file + '.unfinished')
    unfinished.write_text(json.dumps(result), encoding='utf-8')
    os.replace(unfinished, file)
    os._exit(0)


def _end(process: subprocess.Popen) -> None:
    """End the process with all of its children, which share its session."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _reason(code: int, errors: Path) -> str:
    if code < 0:
        return f'the process was ended by signal {-code} ({signal.Signals(-code).name})'
    with errors.open('rb') as file:
        file.seek(max(0, errors.stat().st_size - _TAIL))
        text = file.read().decode(errors='replace')
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    last = ''.join(c for c in lines[-1][:200] if c.isprintable()) if lines else ''
    return (f'the process ended with code {code} before there was a result'
            + (f': {last}' if last else ''))
