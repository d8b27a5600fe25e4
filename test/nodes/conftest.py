import pytest
from ros_processes import ros_domain


@pytest.fixture
def ros(tmp_path):
    """A ROS domain of its own; see test/ros_processes.py."""
    with ros_domain(tmp_path) as domain:
        yield domain
