import os

import pytest
from ros_processes import ros_domain


@pytest.fixture
def ros(tmp_path):
    """A ROS domain of its own; see test/ros_processes.py."""
    with ros_domain(tmp_path) as domain:
        yield domain


@pytest.fixture(scope='session')
def times():
    """Return how many times: ``times(quick, thorough)``; UR5_ROS_THOROUGH is thorough."""
    return lambda quick, thorough: thorough if os.environ.get('UR5_ROS_THOROUGH') else quick
