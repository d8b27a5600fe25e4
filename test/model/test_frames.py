"""What comes in another frame does in ``base`` what it did there; other frames are refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.frames import pose_in_base, wrench_in_base
from ur5_ros.model.kinematics import forward_kinematics

TURNED = np.diag([-1.0, -1.0, 1.0, 1.0])
POSE = np.array([[1.0, 0.0, 0.0, 0.3], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.1],
                 [0.0, 0.0, 0.0, 1.0]])
Q = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
FORCE, TORQUE = [10.0, 5.0, -3.0], [1.0, -2.0, 3.0]


def test_base_link_is_base_turned_by_half_a_turn_and_other_frames_are_refused():
    assert_allclose(pose_in_base(POSE, 'base'), POSE)
    assert_allclose(pose_in_base(POSE, 'base_link'), TURNED @ POSE)
    assert_allclose(pose_in_base(POSE, 'left_base_link', 'left_'), TURNED @ POSE)
    for frame in ('', 'tool0', 'Base', 'left_base'):
        with pytest.raises(InputError,
                           match=f'frame {frame!r} is not known; .* base or base_link'):
            pose_in_base(POSE, frame)


def test_a_matrix_that_is_no_rotation_is_refused():
    mirrored = np.diag([1.0, 1.0, -1.0, 1.0])
    for bad in (mirrored, 2.0 * np.eye(4), np.eye(3), np.full((4, 4), np.nan)):
        with pytest.raises(InputError):
            pose_in_base(bad, 'base')


@pytest.mark.parametrize('prefix', ['', 'left_'])
@pytest.mark.parametrize('name', ['ur5', 'ur10e'])
def test_a_wrench_has_the_same_power_in_every_frame(name, prefix):
    arm, random = load_arm(name), np.random.default_rng(4)
    tool = forward_kinematics(Q + arm.angle_offset, arm)[:3, :3]
    axes = {'base': np.eye(3), 'base_link': TURNED[:3, :3], 'tool0': tool, '': np.eye(3)}
    for frame, to_base in axes.items():
        wrench = wrench_in_base(FORCE, TORQUE, frame and prefix + frame, Q, arm, prefix)
        velocity, rate = random.normal(size=(2, 3))  # of the tool, in the axes of the frame
        assert_allclose(wrench @ np.concatenate([to_base @ velocity, to_base @ rate]),
                        np.dot(FORCE, velocity) + np.dot(TORQUE, rate))


@pytest.mark.parametrize('force, frame, match', [
    (FORCE, 'world', "wrench in frame 'world'; give left_base, left_base_link or left_tool0"),
    (FORCE, 'base', "wrench in frame 'base'; give left_base"),
    ([np.nan, 0.0, 0.0], 'left_base', 'give three finite numbers each'),
    ([0.0, 1.0], 'left_base', 'give three finite numbers each'),
    ([0.0, 0.0, 1.1e5], 'left_base', 'of at most 100000'),
])
def test_a_wrench_without_frame_or_size_is_refused(force, frame, match):
    with pytest.raises(InputError, match=match):
        wrench_in_base(force, TORQUE, frame, Q, load_arm('ur5'), 'left_')


def test_numbers_in_base_are_not_changed():
    assert_array_equal(wrench_in_base(FORCE, TORQUE, 'base', Q, load_arm('ur5')), FORCE + TORQUE)
