"""Identification finds what predicts other torques, with errors that hold."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.identification.arm_file import identified_yaml, write_arm
from ur5_ros.analysis.identification.identify import base_of, identify
from ur5_ros.analysis.identification.inertia import nearest_bodies
from ur5_ros.config import load_arm, parse_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.regressor import inertial_parameters

FRICTION = {'friction.viscous': [2.0, 2.0, 2.0, 0.5, 0.5, 0.5],
            'friction.coulomb': [1.0, 1.0, 1.0, 0.2, 0.2, 0.1]}


@pytest.fixture(scope='module')
def other(looped):
    return looped(duration=6.0, sim=FRICTION)


def test_a_clean_exciting_run_predicts_another_runs_torque(looped, other):
    found = identify([looped('exciting', duration=30.0, sim=FRICTION)],
                     load_arm('ur5_description'), other)
    assert found.test_max.max() < 1e-6
    np.testing.assert_allclose(found.viscous, FRICTION['friction.viscous'], atol=1e-6)
    np.testing.assert_allclose(found.coulomb, FRICTION['friction.coulomb'], atol=1e-6)
    assert found.moved < 1.0
    # the file is an arm that every command takes, and moves as the true one
    arm, true = parse_arm(identified_yaml(found), 'identified'), load_arm('ur5_real')
    states = np.random.default_rng(2).uniform(-1.5, 1.5, (3, 50, 6))
    np.testing.assert_allclose(inverse_dynamics(*states, arm), inverse_dynamics(*states, true),
                               atol=1e-8)
    assert arm.has_tensors


def test_encoder_noise_costs_less_than_a_percent(looped, other):
    noisy = looped('exciting', duration=30.0, sim={
        **FRICTION, 'noise.velocity': 1e-4, 'noise.position': 1e-5})
    found = identify([replace(noisy, truth=None)], load_arm('ur5_description'), other)
    assert np.all(found.test_rms[:5] < 0.01 * found.torque_rms[:5])
    assert found.test_rms[5] < 1e-3  # joint 6 carries 0.2 N m: the error is given as it is
    assert np.all(np.abs(found.viscous - FRICTION['friction.viscous'])
                  < 6 * found.viscous_error + 1e-3)


def test_base_parameters_are_what_motion_and_torque_determine():
    arm = load_arm('ur5')
    combination, columns = base_of(arm)
    # 36 combinations of the links (Gautier), and five rotors: the first is one with link 1,
    # the last with link 6 where the axes do not couple them
    assert combination.shape == (len(columns), 66) and 36 <= len(columns) <= 42
    np.testing.assert_allclose(combination[:, columns], np.eye(len(columns)), atol=1e-12)


def test_physical_parameters_stay_and_others_become_physical():
    arm = load_arm('ur5')
    x = np.concatenate([inertial_parameters(arm), arm.armature])
    np.testing.assert_array_equal(nearest_bodies(x), x)
    x[20], x[65] = -0.5, -1.0
    better = nearest_bodies(x)
    assert better[20] > 0.0 and better[65] == 0.0
    np.testing.assert_allclose(nearest_bodies(better), better, atol=1e-9)


def test_a_run_that_does_not_excite_the_joints_is_refused(looped):
    with pytest.raises(InputError, match='does not move|distinguish the parameters'):
        identify([looped('joint_step', duration=1.0)])


def test_an_arm_file_is_never_overwritten(looped, other, tmp_path):
    found = identify([looped('exciting', duration=30.0, sim=FRICTION)], None, other)
    write_arm(found, tmp_path / 'arm.yaml')
    assert load_arm(str(tmp_path / 'arm.yaml')).name == 'identified'
    with pytest.raises(InputError, match='exists already'):
        write_arm(found, tmp_path / 'arm.yaml')
