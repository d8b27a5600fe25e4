"""An excitation trajectory keeps its limits and excites what it promises."""

import numpy as np
import pytest
import yaml

from ur5_ros.analysis.identification.base_parameters import base_of, inertial_columns
from ur5_ros.analysis.identification.exciting.clearance import clearance_of
from ur5_ros.analysis.identification.exciting.excitation import (
    excite,
    predicted_errors,
    scaled_columns,
)
from ur5_ros.analysis.identification.exciting.files import (
    experiment_yaml,
    trajectory_yaml,
    write_excitation,
)
from ur5_ros.analysis.identification.exciting.trial import trial_errors
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import experiment_trajectory
from ur5_ros.control.profiles import joint_waves
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.kinematics import link_transforms
from ur5_ros.signals import JOINT_NAMES

ACCELERATION, CLEARANCE = 3.0, 0.15


@pytest.fixture(scope='module', params=['ur5', 'ur10e'])
def arm(request):
    return load_arm(request.param)


@pytest.fixture(scope='module')
def found(arm):
    return excite(arm, seconds=20.0, budget=6.0, acceleration=ACCELERATION,
                  clearance=CLEARANCE)


@pytest.fixture(scope='module')
def motion(found):
    return joint_waves(np.arange(0.0, 20.0, 0.002), found.experiment)


def test_limits_hold_at_every_millisecond_of_two(found, motion, arm):
    limits = arm.limits
    assert np.all(motion.q > limits.lower) and np.all(motion.q < limits.upper)
    assert np.all(np.abs(motion.qd) <= limits.velocity)
    assert np.all(np.abs(motion.qdd) <= ACCELERATION * 1.001)
    torque = inverse_dynamics(motion.q + arm.angle_offset, motion.qd, motion.qdd, arm)
    assert np.all(np.abs(torque) <= limits.effort)
    # positions, speeds and accelerations belong together
    np.testing.assert_allclose(np.gradient(motion.q, 0.002, axis=0)[1:-1], motion.qd[1:-1],
                               atol=1e-4)
    np.testing.assert_allclose(motion.qd[[0, -1]], 0.0, atol=1e-2)


def test_elbow_wrists_and_tool_stay_above_the_table(motion, arm):
    height = link_transforms(motion.q + arm.angle_offset, arm)[:, 1:, 2, 3]
    assert height.min() > 0.95 * CLEARANCE
    assert clearance_of(motion.q + arm.angle_offset, arm).min() > 0.95 * CLEARANCE


def test_the_condition_number_is_that_of_the_motion_and_small(found, motion, arm):
    part = [values[::10] for values in motion]
    friction = [value[..., None] * np.eye(6) for value in (part[1], np.tanh(part[1] / 0.02))]
    inertial = inertial_columns(part[0] + arm.angle_offset, *part[1:], arm)
    x = np.concatenate([inertial[..., base_of(arm).columns], *friction], axis=-1)
    condition = np.linalg.cond(scaled_columns(x.reshape(-1, x.shape[-1])))
    assert found.condition == pytest.approx(condition, rel=0.02)
    assert found.condition < 200.0 and found.condition_raw < 2000.0


def test_a_trial_has_the_errors_that_were_predicted(found, arm):
    error, away = trial_errors(found, arm)
    ratio = error / found.error
    assert 0.6 < np.median(ratio) < 1.8
    assert np.mean(away < 3.0 * error) > 0.9


def test_predicted_errors_are_those_of_the_textbook():
    # one column of ones: the error of a mean of n samples is sigma / sqrt(n)
    x = np.tile(np.eye(6), (50, 1))  # 50 states at 50 Hz = one second = 100 samples of noise
    np.testing.assert_allclose(predicted_errors(x, np.full(6, 2.0)), 2.0 / np.sqrt(100.0))


def test_the_files_hold_the_same_motion(found, motion, arm, tmp_path):
    beside = write_excitation(found.experiment, tmp_path / 'motion.yaml')
    again = load_experiment(str(tmp_path / 'motion.yaml'))
    np.testing.assert_allclose(joint_waves(np.arange(0.0, 20.0, 0.002), again).q, motion.q,
                               atol=1e-7)
    experiment_trajectory(again, arm, 500, 0.02)
    message = yaml.safe_load(beside.read_text())
    assert message['joint_names'] == list(JOINT_NAMES)
    times = [each['time_from_start'] for each in message['points']]
    seconds = np.array([each['sec'] + 1e-9 * each['nanosec'] for each in times])
    assert np.all(np.diff(seconds) > 0.0) and seconds[-1] == 20.0
    points = np.array([each['positions'] for each in message['points']])
    np.testing.assert_allclose(
        points, joint_waves(seconds, found.experiment).q, atol=1e-7)
    with pytest.raises(InputError, match='exists'):
        write_excitation(found.experiment, tmp_path / 'motion.yaml')


def test_the_arm_that_moves_so_is_identified(looped, tmp_path):
    found = excite(load_arm('ur5_real'), seconds=15.0, budget=3.0)
    file = tmp_path / 'motion.yaml'
    file.write_text(experiment_yaml(found.experiment))
    run = looped(str(file), duration=15.0, control_rate=500, sim={'noise.velocity': 1e-3})
    reported = identify([run], load_arm('ur5_description'))
    assert reported.not_excited == ()
    assert trajectory_yaml(found.experiment).startswith('joint_names: [shoulder_pan_joint')


def test_an_arm_that_cannot_keep_clear_is_refused():
    with pytest.raises(InputError, match='within its limits'):
        excite(load_arm('ur3'), seconds=10.0, budget=1.0, clearance=2.0)
