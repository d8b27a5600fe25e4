import pytest
from ros_interfaces import provide_interfaces
from ros_processes import ros_domain


@pytest.fixture
def ros(tmp_path):
    """A ROS domain of its own; see test/ros_processes.py."""
    with ros_domain(tmp_path) as domain:
        yield domain


@pytest.fixture(scope='session')
def interfaces():
    """Variables that make the types of test/interfaces importable in a child process."""
    return provide_interfaces()
