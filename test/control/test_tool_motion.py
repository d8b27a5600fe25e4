"""Inverse kinematics along a tool motion: one branch without a jump, or the sample to blame."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.profiles import ToolSamples
from ur5_ros.control.tool_motion import follow
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics

MIDDLE = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])


def wave(count=500):
    w = np.linspace(0.0, 2.0 * np.pi, count)[:, None]
    return MIDDLE + 0.3 * np.sin(w * [1, 2, 3, 1, 2, 3])


def followed(poses, near, arm):
    still = np.zeros((len(poses), 6))
    return follow(ToolSamples(poses, still, still), np.arange(len(poses)) / 100.0, near, arm, 0.0)


def poses_of(q, arm):
    return forward_kinematics(q + arm.angle_offset, arm)


@pytest.mark.parametrize('name', ['ur5', 'ur5_kebria2016', 'ur3e', 'ur10'])
def test_a_path_comes_back_as_the_joint_motion_it_was_made_of(name):
    arm, q = load_arm(name), wave()
    found, branch = followed(poses_of(q, arm), q[0] + 0.01, arm)
    assert_allclose(found.q, q, atol=1e-9)
    assert branch.candidates >= 4 and 0.1 < branch.singularity < 1.0


def test_turns_are_carried_on_along_the_path():
    arm = load_arm('ur3e')  # wrist 3 turns without a limit
    q = np.repeat(MIDDLE[None], 400, axis=0)
    q[:, 5] = np.linspace(0.0, 30.0, 400)
    assert_allclose(followed(poses_of(q, arm), q[0], arm)[0].q, q, atol=1e-9)
    ur5, q = load_arm('ur5'), wave() + 2.0 * np.pi * np.array([0, 1, -1, 1, 1, 0])
    assert_allclose(followed(poses_of(q, ur5), q[0], ur5)[0].q, q, atol=1e-9)


def test_a_jump_is_refused():
    arm = load_arm('ur5')
    poses = poses_of(wave(), arm)
    poses = np.concatenate([poses[:125], poses[375:]])
    with pytest.raises(InputError, match=r'sample 126 of 250 .*jump to another branch'):
        followed(poses, wave()[0], arm)


def test_a_path_out_of_reach_is_refused():
    arm = load_arm('ur5')
    poses = np.repeat(poses_of(MIDDLE, arm)[None], 300, axis=0)
    poses[200:, 2, 3] += 3.0
    with pytest.raises(InputError, match='sample 201 of 300 .* out of reach'):
        followed(poses, MIDDLE, arm)


def test_a_path_beyond_the_limits_is_refused():
    arm = load_arm('ur5')
    arm = replace(arm, limits=replace(arm.limits, upper=np.array([7.0] * 5 + [1.0])))
    q = np.repeat(MIDDLE[None], 400, axis=0)
    q[:, 5] = np.linspace(0.0, 2.0, 400)
    with pytest.raises(InputError, match='sample 201 of 400 .* wrist_3_joint at 1.0025 rad'):
        followed(poses_of(q, arm), q[0], arm)
