"""The model against recordings of a real UR5 (beside the repository; skipped where absent)."""

import gzip
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.regressor import dynamics_regressor, inertial_parameters

FOLDER = Path(__file__).parents[3] / 'shared' / 'real_ur5'
MOTIONS = ['motion3_fast', 'motion5_slow', 'motion6_long', 'motion7_short']

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(),
                                reason=f'no recordings of a real UR5 in {FOLDER}')


def recording(motion):
    """Return a function: column prefix -> (n, 6)."""
    with gzip.open(FOLDER / f'{motion}.csv.gz', 'rt') as file:
        names = file.readline().strip().split(',')
        data = np.loadtxt(file, delimiter=',')
    return lambda prefix: data[:, [names.index(f'{prefix}_{i}') for i in range(1, 7)]]


def rotation(vector):
    """Return the matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector, axis=-1)[:, None, None]
    k = np.zeros((len(vector), 3, 3))
    x, y, z = vector.T / angle[:, 0, 0]
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -z, y, -x
    k = k - np.swapaxes(k, 1, 2)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def between(a, b):
    """Return the angle between rotation matrices, exact for small ones."""
    t = np.swapaxes(a, 1, 2) @ b
    sine = np.stack([t[:, 2, 1] - t[:, 1, 2], t[:, 0, 2] - t[:, 2, 0], t[:, 1, 0] - t[:, 0, 1]])
    return np.arcsin(0.5 * np.linalg.norm(sine, axis=0))


def fitted_armature(column):
    """
    Return rotor inertia and standard error of six joints from one recording.

    What is left over is no white noise, so the error is taken from its sums over whole seconds.
    """
    arm = load_arm('ur5_controller')
    q, qd, qdd = column('q_target'), column('qd_target'), column('qdd_target')
    rest = column('m_target') - dynamics_regressor(q, qd, qdd, arm) @ inertial_parameters(arm)
    power = np.sum(qdd ** 2, axis=0)
    armature = np.sum(qdd * rest, axis=0) / power
    score = qdd * (rest - armature * qdd)
    seconds = np.add.reduceat(score, np.arange(0, len(q), 125), axis=0)
    return armature, np.sqrt(np.sum(seconds ** 2, axis=0)) / power


@pytest.mark.parametrize('motion', MOTIONS)
def test_forward_kinematics_is_the_tool_pose_that_the_robot_reports(motion):
    column = recording(motion)
    pose = forward_kinematics(column('q_actual'), load_arm('ur5'))
    tool = column('tool_vector')
    assert np.linalg.norm(pose[:, :3, 3] - tool[:, :3], axis=1).max() < 2e-6
    assert between(pose[:, :3, :3], rotation(tool[:, 3:])).max() < 5e-6


@pytest.mark.parametrize('motion', MOTIONS)
def test_inverse_dynamics_is_the_torque_that_the_controller_computes(motion):
    column = recording(motion)
    tau = inverse_dynamics(column('q_target'), column('qd_target'), column('qdd_target'),
                           load_arm('ur5_controller'))
    error = tau - column('m_target')
    assert np.sqrt(np.mean(error ** 2, axis=0)).max() < 0.005


def test_armature_fitted_on_one_motion_predicts_the_others():
    armature, deviation = fitted_armature(recording('motion6_long'))
    arm = load_arm('ur5_controller')
    np.testing.assert_allclose(armature, arm.armature, rtol=0.006)
    assert np.all(deviation < 3e-4)
    for motion in MOTIONS:
        column = recording(motion)
        q, qd, qdd = column('q_target'), column('qd_target'), column('qdd_target')
        tau = dynamics_regressor(q, qd, qdd, arm) @ inertial_parameters(arm) + armature * qdd
        error = tau - column('m_target')
        assert np.sqrt(np.mean(error ** 2, axis=0)).max() < 0.005


def test_the_digit_swap_of_the_paper_is_seen_by_the_robot():
    column = recording('motion3_fast')
    paper = load_arm('ur5_kebria2016')
    pose = forward_kinematics(column('q_actual') + paper.angle_offset, paper)
    off = np.linalg.norm(pose[:, :3, 3] - column('tool_vector')[:, :3], axis=1)
    np.testing.assert_allclose(off, 9e-5, atol=3e-6)


def test_standing_still_the_controller_holds_gravity_of_9_82():
    column = recording('motion6_long')
    still = np.all((column('qd_target') == 0.0) & (column('qdd_target') == 0.0), axis=1)
    assert still.sum() > 100
    arm = load_arm('ur5_controller')
    g, held = gravity_torque(column('q_target')[still], arm), column('m_target')[still]
    fitted = 9.82 * np.sum(g * held) / np.sum(g * g)
    assert abs(fitted - 9.82) < 5e-4
    assert np.abs(g - held).max() < 0.003
    assert np.abs(g * 9.81 / 9.82 - held).max() > 0.02


def test_the_controller_computes_with_point_masses():
    arm = load_arm('ur5_controller')
    extended = replace(arm, inertia=load_arm('ur5').inertia)
    column = recording('motion3_fast')
    q, qd, qdd = column('q_target'), column('qd_target'), column('qdd_target')
    errors = []
    for one in (arm, extended):
        rest = column('m_target') - dynamics_regressor(q, qd, qdd, one) @ inertial_parameters(one)
        armature = np.sum(qdd * rest, axis=0) / np.sum(qdd ** 2, axis=0)
        errors.append(np.sqrt(np.mean((rest - armature * qdd) ** 2, axis=0)).max())
    assert errors[0] < 0.005
    assert errors[1] > 0.1
