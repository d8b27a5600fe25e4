"""A second simulator or controller on the topics of a run is named as the cause."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import RecordedEvent
from ur5_ros.analysis.validate import validate


@pytest.fixture(scope='module')
def unanswered(repo):
    """Return a run of which 9 states have no answer, as where answers went elsewhere."""
    run = load_run(repo / 'bags/golden')
    command = run.command.copy()
    command[100:109] = np.nan
    return replace(run, command=command)


def refused(run, reason):
    return RecordedEvent(int(run.stamp[105]), 'refused', reason, {
        'topic': '/joint_command', 'reason': reason, 'count': 3004})


def test_a_second_simulator_seen_by_the_controller_is_the_cause(unanswered):
    summary = {**unanswered.control.summary, 'counters': {'/joint_states: two robots': 3}}
    result = validate(replace(unanswered, control=replace(unanswered.control, summary=summary)))
    assert result.check('pairing').verdict == 'fail'
    assert result.causes[0]['kind'] == 'two simulators'
    assert 'second simulator' in result.causes[0]['sentence']


def test_answers_to_states_of_another_simulator_are_the_cause(unanswered):
    result = validate(replace(unanswered, events=(
        refused(unanswered, 'stamp of a state not yet published'),)))
    assert '3004 commands for states that it had not published' in result.causes[0]['sentence']
    assert 'ROS_DOMAIN_ID' in result.causes[0]['sentence']


def test_two_controllers_are_named(unanswered):
    event = RecordedEvent(int(unanswered.stamp[0]), 'publishers', '2 publishers command the arm: '
                          'one, two; the first valid answer acts', {'names': ['one', 'two']})
    result = validate(replace(unanswered, events=(event,)))
    assert result.causes[0]['kind'] == 'two controllers'
    assert 'one, two' in result.causes[0]['sentence']


def test_a_refusal_for_another_reason_blames_no_other_robot(unanswered):
    other = validate(replace(unanswered, events=(refused(unanswered, 'stamp of an old state'),)))
    assert other.causes == ()


def test_a_run_that_passes_names_nobody(unanswered, repo):
    whole = load_run(repo / 'bags/golden')
    result = validate(replace(whole, events=(
        refused(whole, 'stamp of a state not yet published'),)))
    assert result.passed and result.causes == ()
