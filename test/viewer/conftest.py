"""One short run of plant and law, and a browser to show it."""

import pytest
from chromium import Chromium

from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config


@pytest.fixture(scope='session')
def run():
    """Return six seconds of the paper's experiment at 250 Hz."""
    return as_run(run_closed_loop(run_config(control_rate=250, physics_rate=250, duration=6.0)),
                  'six_seconds')


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    """Headless Chromium, a fresh one a module."""
    browser = Chromium(tmp_path_factory.mktemp('profile'))
    yield browser
    browser.close()
