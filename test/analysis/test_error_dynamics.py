"""The error equation, sampled and continuous, and the gains read back from it."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.gains import recover_gains
from ur5_ros.analysis.error_dynamics import (
    continuous_matrix,
    error_dynamics,
    exponential,
    stretches,
)
from ur5_ros.analysis.laws import laws_of
from ur5_ros.analysis.validate import validate

TEN = 10.0 * np.eye(6)


def test_the_exponential_gives_the_papers_error_curve():
    # Kp = Kd = 10: e/e0 = (l2 exp(-l1 t) - l1 exp(-l2 t)) / (l2 - l1), l = 5 -+ sqrt 15
    slow, fast = 5.0 - np.sqrt(15.0), 5.0 + np.sqrt(15.0)
    for t in (0.001, 0.5, 3.592, 20.0):
        flow = exponential(t * continuous_matrix(TEN, TEN))
        expected = (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow)
        assert flow[0, 0] == pytest.approx(expected, rel=1e-10)


def test_the_exponential_knows_double_poles():
    # Kp = 25, Kd = 10: both poles at -5, e/e0 = (1 + 5 t) exp(-5 t)
    flow = exponential(0.3 * continuous_matrix(25.0 * np.eye(6), TEN))
    assert flow[2, 2] == pytest.approx(2.5 * np.exp(-1.5), rel=1e-12)


def test_the_error_follows_the_sampled_equation_to_rounding(clean_run):
    found = error_dynamics(clean_run, laws_of(clean_run), clean_run.steps)
    assert np.nanmax(np.abs(found.step)) < 1e-13
    assert np.abs(found.error - found.sampled).max() < 1e-12
    assert 1e-6 < np.abs(found.error - found.continuous).max() < 1e-3


def test_a_stretch_ends_where_the_law_was_not_in_charge(clean_run):
    counted = clean_run.steps.copy()
    counted[[100, 101, 500]] = False
    assert stretches(counted) == [(0, 100), (102, 500), (501, len(counted))]
    found = error_dynamics(clean_run, laws_of(clean_run), counted)
    assert np.isnan(found.step[100]).all() and np.isnan(found.sampled[101]).all()
    assert np.nanmax(np.abs(found.error - found.sampled)) < 1e-12


def test_other_gains_than_the_parameters_say_fail(simulated):
    run = simulated(seconds=2.0, kp=12.0)
    reported = replace(run.control, parameters={**run.control.parameters, 'kp': [10.0]})
    result = validate(replace(run, control=reported))
    assert result.check('error step').verdict == 'fail'
    check = result.check('gains')
    assert check.verdict == 'fail' and 'Kp 12' in check.sentence


@pytest.mark.parametrize('noise', [0.0, 1e-4])
def test_gains_are_read_back_within_their_errors(looped, noise):
    run = looped('kebria_fig11', 'ur5_real', 4.0, sim={'noise.velocity': noise},
                 control={'kp': [20.0], 'kd': [9.0]})
    run = replace(run, truth=None)
    found = error_dynamics(run, laws_of(run), run.steps)
    for gains in recover_gains(run, found, *laws_of(run), run.steps):
        assert abs(gains.kp - 20.0) < 5 * gains.kp_error + 0.02
        assert abs(gains.kd - 9.0) < 5 * gains.kd_error + 0.01
        assert gains.kp_error < 1.0


def test_modes_without_a_linear_promise_are_not_judged_by_it(looped):
    run = looped('joint_step', 'ur5_real', 1.0, control={'mode': 'gravity_pd'})
    result = validate(run)
    assert result.check('error step').verdict == 'not applicable'
    assert result.check('tool position').verdict == 'not applicable'
    assert result.check('residual, controller arm').verdict == 'pass'
