import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.targets import pose_matrix, solve_pose
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.signals import JOINT_NAMES

HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
TURNED = np.diag([-1.0, -1.0, 1.0, 1.0])


@pytest.mark.fault(23)
def test_a_quaternion_that_is_not_normalised_is_refused_with_its_norm():
    with pytest.raises(InputError, match='norm 2; give one of norm 1'):
        pose_matrix([0, 0, 0], [0, 0, 0, 2.0])
    with pytest.raises(InputError, match='norm 0'):
        pose_matrix([0, 0, 0], [0, 0, 0, 0])
    with pytest.raises(InputError, match='finite'):
        pose_matrix([0, np.nan, 0], [0, 0, 0, 1])


def test_single_precision_quaternions_pass_and_make_exact_rotations():
    quat = np.array([0.1, -0.5, 0.3, 0.8], dtype=np.float32)
    quat /= np.linalg.norm(quat)
    rotation = pose_matrix([1, 2, 3], quat)[:3, :3]
    assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)


@pytest.mark.parametrize('name', ['ur5', 'ur5_kebria2016', 'ur10e', 'ur3e'])
def test_a_pose_taken_from_a_configuration_is_solved_by_that_configuration(name):
    arm = load_arm(name)
    random = np.random.default_rng(3)
    for _ in range(50):
        q = random.uniform(-3.0, 3.0, 6)
        pose = forward_kinematics(q + arm.angle_offset, arm)
        target, branch = solve_pose(pose, q, arm, 0.1)
        assert_allclose(target, q, atol=1e-6)
        assert 2 <= branch.candidates <= 8
        assert branch.name.startswith('shoulder ')


def test_turns_by_two_pi_are_kept_and_limits_respected():
    arm = load_arm('ur5')
    q = HOME + [0, 0, 0, 0, 0, 2 * np.pi]  # wrist 3 more than a turn around, still allowed
    q[5] -= 0.5
    target, _ = solve_pose(forward_kinematics(q, arm), q, arm, 0.1)
    assert_allclose(target, q, atol=1e-9)
    near = HOME.copy()
    near[5] = 6.2
    beyond = HOME.copy()
    beyond[5] = 6.4 - 2 * np.pi  # 0.2 rad on, were there no limit at 2 pi
    target, _ = solve_pose(forward_kinematics(beyond, arm), near, arm, 10.0)
    assert np.all(target <= arm.limits.upper)
    assert_allclose(forward_kinematics(target, arm), forward_kinematics(beyond, arm), atol=1e-9)


@pytest.mark.parametrize('singular', [
    [0.2, -1.2, 1.5, -1.9, 0.0, 0.3],  # wrist: sin q5 = 0
    [0.2, -1.2, 1.5, -1.9, np.pi, 0.3],
    [0.2, -1.2, 0.0, -1.9, -1.3, 0.3],  # elbow outstretched
])
def test_a_singular_pose_is_a_target_like_any_other(holding, close_loop, singular):
    # a joint motion passes singularities freely; only tool motions have to keep away from them
    controller, plant = holding(np.array(singular) + 0.2, 500, kp=[400.0], kd=[40.0])
    pose = forward_kinematics(np.array(singular), controller.arm)
    controller.target_pose(pose)
    assert_allclose(controller.status()['ik_singularity_distance'], 0.0, atol=1e-6)
    run = close_loop(controller, plant, 1500)
    assert_allclose(forward_kinematics(run.q[-1], controller.arm), pose, atol=1e-5)


def test_a_pose_that_needs_another_branch_is_refused_never_flipped_to(holding):
    controller, _ = holding(HOME)
    pose = forward_kinematics(HOME + [2.5, 0, 0, 0, 0, 0], controller.arm)
    controller.change({'max_joint_jump': 1.0})
    with pytest.raises(InputError, match='max_joint_jump is 1: go there in steps'):
        controller.target_pose(pose)
    assert controller.status()['state'] == 'refused'
    assert 'target_pose: ' in controller.status()['last_refusal']
    assert controller.status()['refused_inputs'] == 1


@pytest.mark.fault(23, 24)
def test_a_pose_out_of_reach_is_refused(holding):
    controller, _ = holding(HOME)
    with pytest.raises(InputError, match='out of reach'):
        controller.target_pose(pose_matrix([2.0, 0.0, 0.5], [0, 0, 0, 1]))


def test_the_choice_of_branch_is_published(holding):
    controller, plant = holding(HOME)
    controller.target_pose(TURNED @ forward_kinematics(HOME + 0.1, controller.arm), 'base_link')
    status = controller.status()
    assert status['state'] == 'moving'
    assert status['ik_candidates'] == 8
    assert status['ik_branch'] == 'shoulder left, elbow up, wrist flipped'
    assert 0.5 < status['singularity_distance'] < 1.0  # facts: X5 about 0.58 of 0.91 m
    assert 0.5 < status['ik_singularity_distance'] < 1.0
    assert status['seconds_left'] > 0.1


@pytest.mark.parametrize(('names', 'positions', 'words'), [
    (JOINT_NAMES[:5], HOME[:5], 'joint wrist_3_joint is missing'),
    ((*JOINT_NAMES[:5], 'elbow_joint'), HOME, 'joint elbow_joint stands twice'),
    ((*JOINT_NAMES, 'elbow_joint'), [*HOME, 0.0], 'joint elbow_joint stands twice'),
    ((*JOINT_NAMES[:5], 'gripper'), HOME, "unknown joint 'gripper'; the joints are: shoulder"),
    (JOINT_NAMES, HOME[:5], '5 positions for 6 joints'),
    (JOINT_NAMES, [*HOME[:5], np.nan], 'positions hold nan'),
    (JOINT_NAMES, [*HOME[:5], 7.0], 'wrist_3_joint would go to 7.0000 rad; its limits are'),
    ((), (), 'joint shoulder_pan_joint is missing'),
])
def test_wrong_joint_targets_are_refused_and_the_arm_stays(holding, close_loop, names, positions,
                                                           words):
    controller, plant = holding(HOME)
    with pytest.raises(InputError, match=words):
        controller.target_joints(names, positions)
    run = close_loop(controller, plant, 10)
    assert_allclose(run.reference, np.tile(HOME, (10, 1)), atol=0.0)


def test_joints_are_matched_by_name_prefix_included(holding, close_loop):
    controller, plant = holding(HOME, tf_prefix='left_')
    target = HOME + [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    controller.target_joints(['left_' + name for name in JOINT_NAMES[::-1]], target[::-1])
    run = close_loop(controller, plant, 1500)
    assert_allclose(run.reference[-1], target)
    assert_allclose(run.q[-1], target, atol=1e-3)
    with pytest.raises(InputError,
                       match="unknown joint 'shoulder_pan_joint'; the joints are: left_"):
        controller.target_joints(JOINT_NAMES, target)
