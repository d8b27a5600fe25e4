"""Fixtures of the fault tests: a ROS domain of their own, and how thorough to be."""

import json
import os

import pytest
from ros_processes import ros_domain

from ur5_ros.bag.reader import open_bag


@pytest.fixture
def ros(tmp_path):
    """A ROS domain of its own; see test/ros_processes.py."""
    with ros_domain(tmp_path) as domain:
        yield domain


@pytest.fixture
def often():
    """How many times more than in `make test`: `make faults` sets UR5_ROS_THOROUGH."""
    return 10 if os.environ.get('UR5_ROS_THOROUGH') else 1


@pytest.fixture
def events_of():
    """Return what a bag of the simulator recorded as events of one kind: (stamp, values)."""
    def events(folder, kind):
        found = []
        for _, message in open_bag(folder).messages('/ur5_sim/events'):
            status = message['status'][0]
            if status['name'] == kind:
                stamp = message['header']['stamp']
                found.append((stamp['sec'] * 10**9 + stamp['nanosec'],
                              {pair['key']: json.loads(pair['value'])
                               for pair in status['values']}))
        return found
    return events
