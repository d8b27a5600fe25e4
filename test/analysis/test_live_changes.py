"""Gains and mode changed while the law runs: every state is judged by those in force."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.data.run import ParameterChange
from ur5_ros.analysis.laws import laws_of
from ur5_ros.analysis.report.html import html_text
from ur5_ros.analysis.validate import validate
from ur5_ros.loop.repeat import recontrol


def failed(result):
    return [check.sentence for check in result.checks if check.verdict == 'fail']


@pytest.fixture(scope='module')
def stiffened(stepped):
    """Return a run whose gains change at 0.5 s and again at 1 s."""
    changes = {500: {'kp': [100.0], 'kd': [20.0]}, 1000: {'kp': [30.0] * 6}}
    return stepped(steer=changes.get, duration=2.0, experiment='kebria_fig11')


def test_a_run_whose_gains_were_changed_passes_by_the_gains_in_force(stiffened):
    result = validate(stiffened)
    assert not failed(result)
    for name in ('law', 'error step', 'error recursion'):
        assert result.check(name).value < 1e-9
    assert [(law.first, law.end, law.gains.kp[0, 0], law.gains.kd[0, 0])
            for law in laws_of(stiffened)] == [
        (0, 500, 10.0, 10.0), (500, 1000, 100.0, 20.0), (1000, 2000, 30.0, 20.0)]


def test_each_set_of_gains_is_read_back_in_its_time(stiffened):
    check = validate(stiffened).check('gains')
    assert check.verdict == 'pass' and 'each of the 3 sets' in check.sentence
    for law, (kp, kd) in zip(check.details['laws'], ((10, 10), (100, 20), (30, 20)), strict=True):
        assert law['joints']
        for found in law['joints'].values():
            assert found['kp'] == pytest.approx(kp, rel=0.02)
            assert found['kd'] == pytest.approx(kd, rel=0.02)


def test_a_change_that_the_bag_does_not_record_fails(stiffened):
    silent = replace(stiffened, control=replace(stiffened.control, changes=()))
    result = validate(silent)
    assert result.check('law').verdict == result.check('error step').verdict == 'fail'
    assert 'the first at 0.5 s' in result.check('law').sentence


def test_a_change_recorded_one_period_late_fails(stiffened):
    reported = stiffened.control.changes
    late = (reported[0]._replace(stamp=reported[0].stamp + 1_000_000), *reported[1:])
    result = validate(replace(stiffened, control=replace(stiffened.control, changes=late)))
    assert '1 command differs from the law' in result.check('law').sentence


def test_what_was_changed_before_the_first_state_holds_from_the_first(stiffened):
    given = stiffened.control.parameters
    early = (ParameterChange(0, {'kp': given['kp'], 'kd': given['kd']}),
             *stiffened.control.changes)
    reported = replace(stiffened.control, parameters={**given, 'kp': [77.0]}, changes=early)
    assert not failed(validate(replace(stiffened, control=reported)))


def test_only_computed_torque_is_held_to_the_error_equation(stepped):
    changes = {400: {'mode': 'gravity_pd', 'kp': [100.0] * 3 + [5.0] * 3,
                     'kd': [10.0] * 3 + [0.2] * 3},
               800: {'mode': 'computed_torque', 'kp': [50.0], 'kd': [15.0]}}
    run = stepped(steer=changes.get, duration=2.0, experiment='kebria_fig11')
    result = validate(run)
    assert not failed(result)
    assert result.check('law').value < 1e-9 and result.check('error step').value < 1e-9
    assert '400 periods left out' in result.check('error step').sentence
    assert len(result.check('gains').details['laws']) == 2


def test_the_law_runs_again_with_its_changes(stiffened):
    found = recontrol(stiffened)
    assert found.equal, found.sentence
    still = recontrol(replace(stiffened, control=replace(stiffened.control, changes=())))
    assert still.first_stamp == stiffened.stamp[500]


def test_report_and_document_name_the_changes(stiffened):
    result = validate(stiffened)
    reported = result.to_plain()['about']['controller']['changes']
    assert reported[0] == {'after_s': pytest.approx(0.5), 'kp': [100.0], 'kd': [20.0]}
    assert 'kp 100, kd 20 from 0.5 s' in html_text(result)


@pytest.mark.parametrize('gains', [(100.0, 20.0), (25.0, 10.0), (1.0, 2.0), (400.0, 40.0)])
@pytest.mark.parametrize('rate', [1000, 250])
def test_healthy_runs_pass_with_any_gains(looped, gains, rate):
    run = looped('kebria_fig11', 'ur5', control_rate=rate, duration=15.0,
                 control={'kp': [gains[0]], 'kd': [gains[1]]})
    result = validate(run)
    assert not failed(result)
    assert result.check('tool position').verdict == 'pass'
    assert np.isfinite(result.check('tool position').limit)
