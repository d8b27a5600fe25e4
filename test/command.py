"""The command ``ur5`` for tests: in this process, or, where a test is about that, in its own."""

import contextlib
import io
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

from ur5_ros.cli.run import run

#: Starts the command as its entry point does.
PROGRAM = [sys.executable, '-c', 'from ur5_ros.cli import main; main()']


class Ended(NamedTuple):
    code: int
    out: str
    err: str


class Command:
    """Runs command lines in a folder, as a user would."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.environment = {**os.environ, 'COLUMNS': '80'}
        self.environment.pop('FORCE_COLOR', None)

    def __call__(self, *arguments, folder: Path | None = None) -> Ended:
        """Run one in this process, which has loaded the package already."""
        out, err, before = io.StringIO(), io.StringIO(), dict(os.environ)
        with contextlib.chdir(folder or self._folder), contextlib.redirect_stdout(out), \
                contextlib.redirect_stderr(err), _printed_warnings():
            os.environ.clear()
            os.environ.update(self.environment)
            try:
                code = run(list(map(str, arguments)))
            finally:
                os.environ.clear()
                os.environ.update(before)
        return self._ended(code, out.getvalue(), err.getvalue())

    def process(self, *arguments, folder: Path | None = None, seconds: float = 300) -> Ended:
        """Run one in a process of its own."""
        done = subprocess.run([*PROGRAM, *map(str, arguments)], cwd=folder or self._folder,
                              env=self.environment, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=seconds)
        return self._ended(done.returncode, done.stdout, done.stderr)

    @staticmethod
    def _ended(code: int, out: str, err: str) -> Ended:
        assert 'Traceback' not in err + out
        return Ended(code, out, err)


@contextlib.contextmanager
def _printed_warnings():
    """Print warnings on the error output, as outside of pytest."""
    with warnings.catch_warnings():
        warnings.resetwarnings()
        for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning,
                     ResourceWarning):
            warnings.simplefilter('ignore', kind)
        warnings.showwarning = lambda message, category, file, line, *_: print(
            warnings.formatwarning(message, category, file, line), file=sys.stderr)
        yield
