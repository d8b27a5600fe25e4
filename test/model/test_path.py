"""Inverse kinematics along a path: one branch without a jump, or a refusal that says where."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.inverse_kinematics import branch_of
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.path import follow_path

MIDDLE = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])


def wave(arm, count=500):
    w = np.linspace(0.0, 2.0 * np.pi, count)[:, None]
    return arm.angle_offset + MIDDLE + 0.3 * np.sin(w * [1, 2, 3, 1, 2, 3])


def test_a_path_comes_back_as_the_joint_motion_it_was_made_of(arm):
    q = wave(arm)
    found = follow_path(forward_kinematics(q, arm), q[0] + 0.01, arm)
    np.testing.assert_allclose(found, q, atol=1e-9)
    assert np.unique(branch_of(found, arm)).size == 1


def test_turns_are_carried_on_along_the_path():
    arm = load_arm('ur3e')  # wrist 3 turns for ever
    q = np.repeat(MIDDLE[None], 400, axis=0)
    q[:, 5] = np.linspace(0.0, 30.0, 400)
    np.testing.assert_allclose(follow_path(forward_kinematics(q, arm), q[0], arm), q, atol=1e-9)
    q = wave(load_arm('ur5')) + 2.0 * np.pi * np.array([0, 1, -1, 1, 1, 0])
    ur5 = load_arm('ur5')
    np.testing.assert_allclose(follow_path(forward_kinematics(q, ur5), q[0], ur5), q, atol=1e-9)


def test_joint_6_stays_where_it_is_free():
    arm = load_arm('ur5')
    q = np.repeat(MIDDLE[None], 200, axis=0)
    q[:, 4] = 0.0
    q[:, 0] = np.linspace(0.0, 1.0, 200)
    found = follow_path(forward_kinematics(q, arm), q[0], arm)
    np.testing.assert_allclose(found, q, atol=1e-9)


def test_a_jump_is_refused():
    arm = load_arm('ur5')
    poses = forward_kinematics(wave(arm), arm)
    with pytest.raises(ValueError, match=r'pose 250 of the path needs a jump: joint \d'):
        follow_path(np.concatenate([poses[:250], poses[400:]]), wave(arm)[0], arm)


def test_a_path_out_of_reach_is_refused():
    arm = load_arm('ur5')
    poses = np.repeat(forward_kinematics(MIDDLE, arm)[None], 300, axis=0)
    poses[200:, 2, 3] += 3.0
    with pytest.raises(ValueError, match='pose 200 of the path is out of reach'):
        follow_path(poses, MIDDLE, arm)


def test_a_path_beyond_the_limits_is_refused():
    arm = load_arm('ur5')
    limits = replace(arm.limits, upper=np.array([7.0, 7.0, 7.0, 7.0, 7.0, 1.0]))
    q = np.repeat(MIDDLE[None], 400, axis=0)
    q[:, 5] = np.linspace(0.0, 2.0, 400)
    with pytest.raises(ValueError, match=r'pose 200 of the path lies outside .* joint 6'):
        follow_path(forward_kinematics(q, arm), q[0], arm, limits)


def test_bad_arguments_are_named():
    arm = load_arm('ur5')
    poses = forward_kinematics(wave(arm), arm)
    with pytest.raises(ValueError, match=r'T has shape \(4, 4\); give \(n, 4, 4\)'):
        follow_path(poses[0], MIDDLE, arm)
    with pytest.raises(ValueError, match='max_step is -1'):
        follow_path(poses, MIDDLE, arm, max_step=-1)
    with pytest.raises(ValueError, match='q_near has shape'):
        follow_path(poses, MIDDLE[:5], arm)
    poses[7] *= 2.0
    with pytest.raises(ValueError, match='T 7 is no rigid transform'):
        follow_path(poses, MIDDLE, arm)
