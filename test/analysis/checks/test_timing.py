"""A run that was paced by the clock passes timing only if its periods began and were answered."""

from dataclasses import replace

import pytest

from ur5_ros.analysis.checks.recording import timing_check
from ur5_ros.analysis.data.run import RecordedEvent
from ur5_ros.config.validation import load_marks


def paced(run, late=0, events=()):
    """Return the run as one without lockstep, of whose periods some were late."""
    sim = replace(run.sim, parameters={**run.sim.parameters, 'lockstep': False},
                  summary={'counters': {'late_periods': late}})
    return replace(run, sim=sim, events=tuple(events))


def fallback(run, row, active):
    return RecordedEvent(int(run.stamp[row]), 'fallback', '', {'active': active, 'mode': 'brake'})


def test_late_periods_fail_and_are_counted_in_words(clean_run):
    check = timing_check(paced(clean_run, late=2000), load_marks())
    assert check.verdict == 'fail'
    assert check.sentence.startswith(f'2000 of {len(clean_run.stamp)} periods began late')
    assert check.details['late'] == 2000


def test_periods_under_the_fallback_fail_as_well(clean_run):
    events = [fallback(clean_run, 3000, True), fallback(clean_run, 3685, False)]
    check = timing_check(paced(clean_run, events=events), load_marks())
    assert check.verdict == 'fail' and check.details['fallback'] == 685


def test_the_fallback_before_the_first_command_and_after_the_last_is_no_fault(clean_run):
    events = [fallback(clean_run, 0, True), fallback(clean_run, 500, False),
              fallback(clean_run, 8000, True)]
    check = timing_check(paced(clean_run, late=3, events=events), load_marks())
    assert check.verdict == 'pass'
    assert '3 periods began late, 0 passed under the fallback' in check.sentence


@pytest.mark.parametrize('late', [0, 5000])
def test_in_lockstep_nothing_is_late(clean_run, late):
    sim = replace(clean_run.sim, summary={'counters': {'late_periods': late}})
    assert timing_check(replace(clean_run, sim=sim), load_marks()).verdict == 'pass'
