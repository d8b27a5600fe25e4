"""Fixtures of the fault tests: a ROS domain of their own, and how thorough to be."""

import json

import pytest
from long_run import LongRun
from ros_processes import ros_domain

from ur5_ros.bag.reader import open_bag

#: The test that judges it.
LONG_RUN = 'test_over_many_periods'


@pytest.fixture
def ros(tmp_path):
    """A ROS domain of its own; see test/ros_processes.py."""
    with ros_domain(tmp_path) as domain:
        yield domain


@pytest.fixture(scope='session', autouse=True)
def long_run(request, times, tmp_path_factory):
    """A long run in lockstep; `make faults` lets it run beside the other tests."""
    if not any(item.name.startswith(LONG_RUN) for item in request.session.items):
        yield None
        return
    folder = tmp_path_factory.mktemp('long_run')
    run = LongRun(folder, times(20_000, 1_000_000))
    if times(False, True):
        run.start()
    yield run
    run.close()


def pytest_collection_modifyitems(items):
    """Put the long run last."""
    items.sort(key=lambda item: item.name.startswith(LONG_RUN))


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
