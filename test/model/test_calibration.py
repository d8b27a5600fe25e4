"""A calibrated arm: poses and Jacobians as Pinocchio has them, every branch to 1e-12."""

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.calibration import nominal_chain, transform
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.inverse_kinematics import (
    inverse_kinematics,
    inverse_kinematics_batch,
    nearest_solution,
)
from ur5_ros.model.kinematics import (
    forward_kinematics,
    jacobian,
    jacobian_rate,
    link_transforms,
    singularity_factors,
)

ARMS = ('ur3e', 'ur5e', 'ur10e', 'ur20')


def calibrated(name, size=1e-3, seed=3):
    """Return an arm whose joints are off by about a millimetre and a milliradian."""
    arm, random = load_arm(name), np.random.default_rng(seed)
    chain = np.array([step @ transform(random.normal(0.0, size, 3), random.normal(0.0, size, 3))
                      for step in nominal_chain(arm)])
    return replace(arm, calibration=chain)


def away_from_singularities(q, arm):
    """Return where no branch meets another one, shape (n,)."""
    q5, q3, x5 = singularity_factors(q, arm)
    return (np.abs(q5) > 0.1) & (np.abs(q3) > 0.1) & (np.abs(x5) > 0.1 * np.abs(arm.a).sum())


def pinocchio_model(chain):
    model = pinocchio.Model()
    joint = 0
    for i, step in enumerate(chain):
        joint = model.addJoint(joint, pinocchio.JointModelRZ(),
                               pinocchio.SE3(step[:3, :3], step[:3, 3]), f'joint {i + 1}')
    return model, model.createData(), joint


@pytest.fixture
def states():
    return np.random.default_rng(5).uniform(-3.0, 3.0, (40, 6))


@pytest.mark.parametrize('name', ARMS)
def test_the_chain_of_the_dh_table_is_the_dh_table(name, states):
    arm = load_arm(name)
    same = replace(arm, calibration=nominal_chain(arm))
    for function in (forward_kinematics, link_transforms, jacobian):
        np.testing.assert_allclose(function(states, same), function(states, arm), atol=1e-14)
    np.testing.assert_allclose(jacobian_rate(states, states[::-1], same),
                               jacobian_rate(states, states[::-1], arm), atol=1e-13)


@pytest.mark.parametrize('name', ARMS)
def test_poses_and_jacobians_are_those_of_pinocchio(name, states):
    arm = calibrated(name)
    model, data, joint = pinocchio_model(arm.calibration)
    for q, qd in zip(states, states[::-1], strict=True):
        pinocchio.computeJointJacobiansTimeVariation(model, data, q, qd)
        pinocchio.forwardKinematics(model, data, q)
        np.testing.assert_allclose(forward_kinematics(q, arm), data.oMi[joint].homogeneous,
                                   atol=1e-13)
        world = pinocchio.LOCAL_WORLD_ALIGNED
        np.testing.assert_allclose(
            jacobian(q, arm), pinocchio.getJointJacobian(model, data, joint, world), atol=1e-13)
        np.testing.assert_allclose(
            jacobian_rate(q, qd, arm),
            pinocchio.getJointJacobianTimeVariation(model, data, joint, world), atol=1e-12)


@pytest.mark.parametrize('size', [1e-4, 1e-3, 3e-3])
@pytest.mark.parametrize('name', ARMS)
def test_every_branch_reaches_the_pose_to_1e_12(name, size, states):
    arm = calibrated(name, size)
    poses = forward_kinematics(states, arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    reached = forward_kinematics(np.where(valid[..., None], q, 0.0), arm)
    assert np.abs(reached - poses[:, None])[valid].max() < 1e-12
    assert np.isnan(q[~valid]).all()
    regular = away_from_singularities(states, arm)
    assert regular.sum() > 20
    for own, found, mask in zip(states[regular], q[regular], valid[regular], strict=True):
        away = np.abs((found[mask] - own + np.pi) % (2.0 * np.pi) - np.pi).max(axis=1)
        assert away.min() < 1e-9  # the posture that the pose was made of is among them


@pytest.mark.parametrize('name', ARMS)
def test_there_are_as_many_branches_as_without_calibration_away_from_the_edge(name, states):
    arm = calibrated(name, 1e-4)
    poses = forward_kinematics(states, arm)
    _, valid = inverse_kinematics_batch(poses, arm)
    _, nominal = inverse_kinematics_batch(poses, replace(arm, calibration=None))
    regular = away_from_singularities(states, arm)
    assert (valid.sum(axis=1) == nominal.sum(axis=1))[regular].mean() > 0.9
    assert (valid.sum(axis=1) >= nominal.sum(axis=1) - 2).all()


def test_the_branches_of_one_pose_are_those_of_the_batch_and_the_nearest_is_near(states):
    arm = calibrated('ur5e')
    q = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
    pose = forward_kinematics(q, arm)
    found, (every, valid) = inverse_kinematics(pose, arm), inverse_kinematics_batch(pose, arm)
    np.testing.assert_allclose(found.q, every[valid], atol=1e-12)
    assert found.branch.tolist() == np.flatnonzero(valid).tolist() and len(found.q) == 8
    np.testing.assert_allclose(nearest_solution(pose, q, arm), q, atol=1e-12)


def test_a_pose_out_of_reach_has_a_reason():
    arm = calibrated('ur5e')
    pose = forward_kinematics(np.zeros(6), arm)
    pose[:3, 3] *= 3.0
    found = inverse_kinematics(pose, arm)
    assert len(found.q) == 0 and found.reason
    with pytest.raises(InputError, match='T: '):
        nearest_solution(pose, np.zeros(6), arm)


def test_a_chain_that_is_none_is_refused():
    arm = load_arm('ur5e')
    with pytest.raises(ValueError, match='six transforms'):
        replace(arm, calibration=np.eye(4))
    with pytest.raises(ValueError, match='angle_offset'):
        replace(load_arm('ur5_kebria2016'), calibration=nominal_chain(arm))


def test_a_calibration_of_millimetres_changes_gravity_by_less_than_half_a_percent():
    # the dynamics keep the DH table: this is what that leaves out, from the potential energy
    arm = load_arm('ur5e')

    def potential(q, of):
        frames = link_transforms(q, of)
        mass, com, _ = of.bodies
        centre = frames[..., :3, 3] + np.einsum('...ij,...j->...i', frames[..., :3, :3], com)
        return -np.sum(mass * (centre @ of.gravity), axis=-1)

    def gravity(q, of, step=1e-6):
        return np.stack([(potential(q + step * turn, of) - potential(q - step * turn, of))
                         / (2.0 * step) for turn in np.eye(6)], axis=-1)

    random = np.random.default_rng(4)
    q = random.uniform(-np.pi, np.pi, (200, 6))
    nominal = gravity_torque(q, arm)
    np.testing.assert_allclose(gravity(q, arm), nominal, atol=1e-6)
    for _ in range(5):
        off = np.array([transform(random.normal(0.0, 2e-4, 3), random.normal(0.0, 5e-4, 3))
                        for _ in range(6)])
        own = replace(arm, calibration=nominal_chain(arm) @ off)
        moved = np.linalg.norm(forward_kinematics(q, own)[:, :3, 3]
                               - forward_kinematics(q, arm)[:, :3, 3], axis=1).max()
        assert 1e-3 < moved < 5e-3
        away = np.abs(gravity(q, own) - nominal).max()
        assert 1e-3 < away < 0.005 * np.abs(nominal).max()
