import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest


class Ended(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def ur5(tmp_path):
    """Run one command line in an empty folder, as a user would."""
    environment = {**os.environ, 'COLUMNS': '80'}
    environment.pop('FORCE_COLOR', None)

    def run(*arguments, folder=tmp_path, seconds=300):
        done = subprocess.run(
            [sys.executable, '-c', 'from ur5_ros.cli import main; main()',
             *map(str, arguments)],
            cwd=folder, env=environment, capture_output=True, text=True, timeout=seconds)
        assert 'Traceback' not in done.stderr + done.stdout
        return Ended(done.returncode, done.stdout, done.stderr)

    run.environment = environment
    return run


@pytest.fixture(scope='session')
def short_run(tmp_path_factory):
    """A run of 1.5 s, recorded by the loop without ROS."""
    from ur5_ros.loop.closed_loop import run_closed_loop
    from ur5_ros.loop.run_config import run_config
    folder = tmp_path_factory.mktemp('runs') / 'short'
    run_closed_loop(run_config(duration=1.5), folder)
    return folder


@pytest.fixture
def empty(tmp_path: Path) -> Path:
    folder = tmp_path / 'empty'
    folder.mkdir()
    return folder
