from pathlib import Path

import pytest
from command import Command


@pytest.fixture
def ur5(tmp_path):
    """Run command lines in an empty folder; see test/command.py."""
    return Command(tmp_path)


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
