"""Inverse kinematics: complete, exact, distinct, also where branches meet."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.inverse_kinematics import (
    inverse_kinematics,
    inverse_kinematics_batch,
    nearest_solution,
)
from ur5_ros.model.kinematics import forward_kinematics, link_transforms, singularity_factors

TURN = 2.0 * np.pi


def configurations(count, seed):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 6))


def apart(a, b):
    """Return the largest joint difference, turns by 2 pi apart, over the last axis."""
    return np.abs((a - b + np.pi) % TURN - np.pi).max(axis=-1)


def pose_error(q, poses, arm):
    """Return the largest error of position [m] and of rotation [rad]."""
    reached = forward_kinematics(q, arm)
    turned = np.swapaxes(poses[..., :3, :3], -1, -2) @ reached[..., :3, :3]
    sine = 0.5 * np.stack([turned[..., 2, 1] - turned[..., 1, 2],
                           turned[..., 0, 2] - turned[..., 2, 0],
                           turned[..., 1, 0] - turned[..., 0, 1]], axis=-1)
    cosine = 0.5 * (np.trace(turned, axis1=-2, axis2=-1) - 1.0)
    angle = np.arctan2(np.linalg.norm(sine, axis=-1), cosine)
    return np.linalg.norm(reached[..., :3, 3] - poses[..., :3, 3], axis=-1).max(), angle.max()


def assert_all_reach(q, valid, poses, arm):
    position, rotation = pose_error(q[valid], np.repeat(poses, valid.sum(axis=1), axis=0), arm)
    assert position < 1e-9
    assert rotation < 1e-9


def assert_distinct(q, valid):
    for i in range(8):
        for j in range(i):
            both = valid[:, i] & valid[:, j]
            assert not both.any() or apart(q[both, i], q[both, j]).min() > 1e-8


@pytest.mark.parametrize('name', ['ur5', 'ur5_kebria2016', 'ur10e'])
def test_every_configuration_is_found_again_among_exact_and_distinct_solutions(
        name, times, record_property):
    arm = load_arm(name)
    original = configurations(times(10_000, 100_000), 1)
    record_property('configurations', len(original))
    poses = forward_kinematics(original, arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    away = np.where(valid, apart(q, original[:, None]), np.inf).min(axis=1)
    assert away.max() < 1e-8
    assert_all_reach(q, valid, poses, arm)
    assert_distinct(q, valid)
    assert np.all(np.abs(q[valid]) <= np.pi)
    assert np.array_equal(np.unique(valid.sum(axis=1)), [2, 4, 6, 8])


def test_every_arm_of_the_family_is_inverted(arm):
    original = configurations(2000, 2)
    poses = forward_kinematics(original, arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    assert np.where(valid, apart(q, original[:, None]), np.inf).min(axis=1).max() < 1e-8
    assert_all_reach(q, valid, poses, arm)


@pytest.mark.parametrize('signs', [(1, 1), (-1, 1), (1, -1)])
def test_any_signs_of_a2_and_a3_are_inverted(signs):
    arm = load_arm('ur5')
    arm = replace(arm, a=arm.a * np.array([1, *signs, 1, 1, 1]))
    original = configurations(2000, 3)
    poses = forward_kinematics(original, arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    assert np.where(valid, apart(q, original[:, None]), np.inf).min(axis=1).max() < 1e-8
    assert_all_reach(q, valid, poses, arm)


def near_singular(kind, distance, arm, count, seed):
    """Return configurations that lie ``distance`` from a singularity (exactly on it: zero)."""
    rng = np.random.default_rng(seed)
    q = configurations(4 * count, seed)
    side = rng.choice([0.0, np.pi], 4 * count)
    if 'wrist' in kind:
        q[:, 4] = side + distance
    if 'elbow' in kind:
        q[:, 2] = side + distance
    if 'shoulder' in kind:
        sine = -(arm.a[1] * np.cos(q[:, 1]) + arm.a[2] * np.cos(q[:, 1] + q[:, 2])) / arm.d[4]
        if 'elbow' in kind:  # joints 2, 3 upright enough for d5 to make up the rest
            q[:, 1] = np.pi / 2 + 0.1 * q[:, 1] / np.pi
            sine = -(arm.a[1] * np.cos(q[:, 1]) + arm.a[2] * np.cos(q[:, 1] + q[:, 2])) / arm.d[4]
        good = np.abs(sine) < 0.9
        q, sine = q[good], sine[good]
        q[:, 3] = np.arcsin(sine) - q[:, 1] - q[:, 2] + distance
    assert len(q) > 20
    return q[:count]


@pytest.mark.parametrize('kind', ['wrist', 'elbow', 'shoulder', 'wrist elbow', 'wrist shoulder',
                                  'elbow shoulder', 'wrist elbow shoulder'])
@pytest.mark.parametrize('name', ['ur5', 'ur5_kebria2016', 'ur10e'])
def test_solutions_are_exact_and_distinct_near_and_on_every_singularity(kind, name):
    arm = load_arm(name)
    for i, distance in enumerate([0.0, *10.0 ** -np.arange(3.0, 13.0)]):
        for signed in (distance, -distance):
            original = near_singular(kind, signed, arm, 500, i)
            poses = forward_kinematics(original, arm)
            q, valid = inverse_kinematics_batch(poses, arm, q6=original[:, 5])
            assert valid.any(axis=1).all(), f'no solution {signed} from {kind}'
            assert_all_reach(q, valid, poses, arm)
            assert_distinct(q, valid)


def test_on_a_wrist_singularity_joint_6_is_as_given_or_stays():
    arm = load_arm('ur5')
    q = np.array([0.3, -1.2, 1.4, -0.9, 0.0, 0.7])
    pose = forward_kinematics(q, arm)
    for q6 in (-2.0, 0.0, 0.7, 3.0):
        solutions = inverse_kinematics(pose, arm, q6=q6)
        assert solutions.wrist_singular
        straight = np.abs(np.sin(solutions.q[:, 4])) < 1e-9
        assert straight.any()
        assert np.all(solutions.q[straight, 5] == q6)
        assert max(pose_error(solutions.q, pose, arm)) < 1e-9
    kept = inverse_kinematics(pose, arm, q_near=q)
    assert apart(kept.q, q).min() < 1e-9
    np.testing.assert_allclose(nearest_solution(pose, q, arm), q, atol=1e-9)


def test_merged_branches_are_one_solution():
    arm = load_arm('ur5')
    outstretched = forward_kinematics(np.array([0.2, -0.9, 0.0, 0.4, 1.0, 0.0]), arm)
    assert len(inverse_kinematics(outstretched, arm).q) < 8
    q, valid = inverse_kinematics_batch(outstretched, arm)
    assert_distinct(q[None], valid[None])


def branch_of(q, arm):
    """Return 4 shoulder + 2 elbow + wrist from the signs of the factors of det J."""
    sin_q5, sin_q3, x5 = singularity_factors(q, arm)
    right, flipped = x5 > 0.0, sin_q5 < 0.0
    down = (sin_q3 * arm.a[1] * arm.a[2] < 0.0) != right
    return 4 * right + 2 * down + flipped


def test_branch_labels_are_the_signs_of_the_three_factors(arm):
    poses = forward_kinematics(configurations(2000, 4), arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    slots = np.broadcast_to(np.arange(8), valid.shape)
    np.testing.assert_array_equal(branch_of(q[valid], arm), slots[valid])


def test_labels_read_as_the_arm_looks():
    arm = load_arm('ur5')
    home = np.array([0.0, -np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2, 0.0])
    solutions = inverse_kinematics(forward_kinematics(home, arm), arm)
    i = int(np.argmin(apart(solutions.q, home)))
    assert (solutions.shoulder[i], solutions.elbow[i], solutions.wrist[i]) == (
        'left', 'up', 'flipped')
    np.testing.assert_array_equal(branch_of(solutions.q, arm), solutions.branch)


def test_one_pose_and_many_give_the_same_bits(arm):
    poses = forward_kinematics(configurations(50, 5), arm)
    q, valid = inverse_kinematics_batch(poses, arm)
    for i, pose in enumerate(poses):
        np.testing.assert_array_equal(inverse_kinematics(pose, arm).q, q[i, valid[i]])


def test_out_of_reach_is_an_empty_result_that_says_why():
    arm = load_arm('ur5')
    far = forward_kinematics(np.zeros(6), arm)
    far[:3, 3] += (0.0, 0.0, 2.0)
    solutions = inverse_kinematics(far, arm)
    assert solutions.q.shape == (0, 6)
    assert 'out of reach' in solutions.reason
    assert '0.81725' in solutions.reason
    # a little beyond the outstretched arm: short by as much as it was moved outwards
    q = np.array([0.2, -0.9, 0.0, -np.pi / 2, 1.0, 0.0])
    edge, outwards = forward_kinematics(q, arm), link_transforms(q, arm)[2, :3, 3]
    outwards = outwards - (0.0, 0.0, arm.d[0])
    edge[:3, 3] += 0.01 * outwards / np.linalg.norm(outwards)
    assert inverse_kinematics(edge, arm).reason.startswith('out of reach by 0.01 m')
    inside = far.copy()
    inside[:2, 3] = arm.d[5] * inside[:2, 2]
    assert 'axis 1' in inverse_kinematics(inside, arm).reason
    assert not inverse_kinematics_batch(far, arm)[1].any()
    with pytest.raises(ValueError, match='out of reach'):
        nearest_solution(far, np.zeros(6), arm)


def test_nearest_solution_uses_turns_within_the_limits():
    arm = load_arm('ur5')
    rng = np.random.default_rng(6)
    for q in rng.uniform(-TURN, TURN, (200, 6)):
        pose = forward_kinematics(q, arm)
        near = q + rng.uniform(-0.02, 0.02, 6)
        found = nearest_solution(pose, near, arm)
        assert np.all(np.abs(found) <= TURN)
        assert np.sum((found - near) ** 2) <= np.sum((q - near) ** 2) + 1e-9


def test_limits_are_in_the_manufacturers_angles():
    paper = load_arm('ur5_kebria2016')
    home = np.array([0.1, -1.5, 1.4, -1.6, -1.5, 0.2])  # q_UR
    tight = replace(paper.limits, lower=home - 0.1, upper=home + 0.1)
    pose = forward_kinematics(home + paper.angle_offset, paper)
    found = nearest_solution(pose, np.zeros(6), paper, tight)
    np.testing.assert_allclose(found - paper.angle_offset, home, atol=1e-9)


def test_an_unlimited_wrist_may_turn_for_ever():
    arm = load_arm('ur3e')
    q = np.array([0.1, -1.5, 1.4, -1.6, -1.5, 40.0])
    found = nearest_solution(forward_kinematics(q, arm), q, arm)
    np.testing.assert_allclose(found, q, atol=1e-9)


def test_limits_that_exclude_every_branch_are_named():
    arm = load_arm('ur5')
    q = np.array([0.1, -1.5, 1.4, -1.6, -1.5, 0.2])
    limits = replace(arm.limits, lower=np.full(6, -0.01), upper=np.full(6, 0.01))
    with pytest.raises(ValueError, match='limits exclude all 8 solutions: joint'):
        nearest_solution(forward_kinematics(q, arm), q, arm, limits)


@pytest.mark.parametrize(('change', 'message'), [
    (lambda t: t[:3], r'T has shape \(3, 4\)'),
    (lambda t: t * np.nan, r'T\[0, 0\] is nan'),
    (lambda t: t * 1.001, r'no rigid transform: .* 0\.00[12]'),
    (lambda t: t + np.diag([0, 0, 0, 0.5]), r'last row differs from \(0, 0, 0, 1\) by 0\.5'),
    (lambda t: t @ np.diag([1.0, 1.0, -1.0, 1.0]), 'det R is -1'),
    (lambda t: 'pose', 'T is no array of real numbers'),
])
def test_a_matrix_that_is_no_pose_is_refused_by_name(change, message):
    arm = load_arm('ur5')
    pose = change(forward_kinematics(np.ones(6), arm))
    for call in (inverse_kinematics, inverse_kinematics_batch):
        with pytest.raises(ValueError, match=message):
            call(pose, arm)


def test_a_bad_pose_among_many_is_named():
    arm = load_arm('ur5')
    poses = forward_kinematics(configurations(5, 7), arm)
    poses[3, :3, :3] *= 1.1
    with pytest.raises(ValueError, match='T 3 is no rigid transform'):
        inverse_kinematics_batch(poses, arm)


@pytest.mark.parametrize('pose_name', ['zero', 'home'])
@pytest.mark.parametrize('q6', [0.0, 0.5, -3.0])
def test_zero_and_home_of_the_manufacturer_are_inverted(pose_name, q6):
    # outstretched with axes 4 and 6 parallel; home (upright) also stands above axis 1
    arm = load_arm('ur5')
    q = np.zeros(6)
    if pose_name == 'home':
        q[[1, 3]] = -np.pi / 2
    pose = forward_kinematics(q, arm)
    solutions = inverse_kinematics(pose, arm, q6=q6)
    assert len(solutions.q)
    assert max(pose_error(solutions.q, pose, arm)) < 1e-9
    near = nearest_solution(pose, q, arm)
    assert np.abs(near - q).max() < 1e-6


def test_one_pose_is_asked_for_where_one_is_answered():
    arm = load_arm('ur5')
    poses = forward_kinematics(configurations(2, 8), arm)
    with pytest.raises(ValueError, match=r'T has shape \(2, 4, 4\); give \(4, 4\)'):
        inverse_kinematics(poses, arm)
    np.testing.assert_array_equal(inverse_kinematics(poses[0].tolist(), arm).q,
                                  inverse_kinematics(poses[0], arm).q)


@pytest.mark.parametrize(('lower', 'message'), [
    (np.zeros(5), r'limits.lower is \[.*\]; give six numbers'),
    (np.array([0.0, np.nan, 0.0, 0.0, 0.0, 0.0]), 'limits.lower is'),
    (np.array([0.0, 0.0, 9.0, 0.0, 0.0, 0.0]), 'limits of joint 3 are 9.0 to 6.28'),
])
def test_limits_that_are_none_are_refused_by_name(lower, message):
    arm = load_arm('ur5')
    limits = replace(arm.limits, lower=lower)
    with pytest.raises(ValueError, match=message):
        nearest_solution(forward_kinematics(np.ones(6), arm), np.ones(6), arm, limits)
