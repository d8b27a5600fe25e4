"""The law computed again: every law without memory, from states and references alone."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.law import law_check
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import TargetWrench
from ur5_ros.config.validation import load_marks
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config

SOFT = {'impedance.stiffness': [800.0, 900.0, 1000.0, 30.0, 25.0, 5.0],
        'impedance.damping': [150.0, 200.0, 180.0, 2.0, 2.0, 0.05]}


def judged(experiment='multi_sine', duration=0.6, **control):
    run = as_run(run_closed_loop(run_config(experiment, duration=duration, control=control)))
    return law_check(run, load_marks()), run


@pytest.mark.parametrize('control', [
    {**SOFT, 'impedance.frame': 'tool'}, {**SOFT, 'impedance.frame': 'base'},
    {**SOFT, 'impedance.frame': 'tool', 'impedance.inertia': [6.0, 5.0, 7.0, 0.3, 0.2, 0.1]},
    {**SOFT, 'impedance.inertia': [6.0, 5.0, 7.0, 0.3, 0.2, 0.1]},
])
def test_a_cartesian_impedance_is_computed_again(control):
    check, run = judged(mode='cartesian_impedance', **control)
    assert check.verdict == 'pass' and check.value < 1e-9, check.sentence
    assert np.abs(run.states.qd).max() > 0.05, 'it moves'


def test_it_is_computed_again_near_a_singularity():
    check, run = judged('tap_wall', 1.2, mode='cartesian_impedance')
    stretched = as_run(run_closed_loop(run_config('joint_step', duration=0.3, control={
        'mode': 'cartesian_impedance', **SOFT}, sim={
            'initial_positions': [0.0, -1.5, 0.0, -1.5, 0.0, 0.0]})))
    for each in (check, law_check(stretched, load_marks())):
        assert each.verdict == 'pass' and each.value < 1e-9, each.sentence
    assert np.abs(run.contact).max() > 1.0, 'the wall is touched'


@pytest.mark.parametrize('mode', ['pd', 'gravity_pd', 'impedance', 'computed_torque'])
def test_the_laws_in_joints_are_computed_again(mode):
    check, _ = judged(mode=mode, kp=[40.0] * 6, kd=[2.0, 2.0, 2.0, 0.2, 0.2, 0.02])
    assert check.verdict == 'pass' and check.value < 1e-9, check.sentence


def test_another_stiffness_than_the_recorded_one_fails():
    _, run = judged(mode='cartesian_impedance', **SOFT)
    other = {**run.control.parameters, 'impedance.stiffness': [801.0, *SOFT[
        'impedance.stiffness'][1:]]}
    check = law_check(replace(run, control=replace(run.control, parameters=other)), load_marks())
    assert check.verdict == 'fail' and 'differ from the law' in check.sentence


def test_a_desired_wrench_is_part_of_the_law_from_its_state_on():
    _, run = judged(mode='cartesian_impedance', **SOFT)
    wrench = TargetWrench(int(run.stamp[300]), np.array([0.0, 0.0, -2.0, 0.0, 0.0, 0.0]))
    check = law_check(replace(run, target_wrenches=(wrench,)), load_marks())
    assert check.verdict == 'fail'
    assert f'the first at {run.t[300]:.4g} s' in check.sentence


def test_a_law_with_a_memory_is_not_computed_again():
    check, _ = judged(mode='pid', kp=[40.0] * 6, kd=[2.0, 2.0, 2.0, 0.2, 0.2, 0.02])
    assert check.verdict == 'not applicable'


def test_it_is_read_from_the_bags(tmp_path):
    run_closed_loop(run_config('tap_wall', duration=1.0), tmp_path / 'run')
    check = law_check(load_run(tmp_path / 'run'), load_marks())
    assert check.verdict == 'pass' and check.value < 1e-9
