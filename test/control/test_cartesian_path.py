import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.cartesian_path import TURN_LENGTH, speed_path, stamped_path
from ur5_ros.control.targets import pose_matrix
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics

ARM = load_arm('ur5')
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
S = 1_000_000_000


def random_poses(seed, count):
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    return np.array([pose_matrix(rng.uniform(-0.3, 0.3, 3), quat / np.linalg.norm(quat))
                     for quat in quats])


def angle_of(matrix):
    return 2.0 * np.arcsin(np.clip(np.linalg.norm(matrix - np.eye(3)) / np.sqrt(8.0), 0.0, 1.0))


def twist_of(before, after, h):
    skew = (after[:3, :3] @ before[:3, :3].T - before[:3, :3] @ after[:3, :3].T) / (2.0 * h)
    return np.array([*(after[:3, 3] - before[:3, 3]) / h, skew[2, 1], skew[0, 2], skew[1, 0]])


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.integers(2, 5), st.booleans())
def test_a_path_passes_its_poses_in_straight_lines_and_turns_about_one_axis(seed, count, stamped):
    poses = random_poses(seed, count)
    if stamped:
        times = np.arange(count) * 2.0
        lines, duration = stamped_path(poses, times), times[-1]
        passed = lines(times).pose
        assert_allclose(passed, poses, atol=1e-9)
    else:
        lines, duration = speed_path(poses, 0.1)
    samples = lines(np.linspace(0.0, duration, 400))
    assert_allclose(samples.pose[[0, -1]], poses[[0, -1]], atol=1e-9)
    assert_allclose(samples.twist[[0, -1]], 0.0, atol=1e-9)
    for pose in samples.pose[::7]:
        off = []
        for a, b in zip(poses[:-1], poses[1:], strict=True):
            way, turn = np.linalg.norm(b[:3, 3] - a[:3, 3]), angle_of(a[:3, :3].T @ b[:3, :3])
            f = np.linalg.norm(pose[:3, 3] - a[:3, 3]) / way
            off.append(max(
                np.linalg.norm(pose[:3, 3] - (1 - f) * a[:3, 3] - f * b[:3, 3]),
                abs(angle_of(a[:3, :3].T @ pose[:3, :3]) - f * turn),
                abs(angle_of(pose[:3, :3].T @ b[:3, :3]) - (1 - f) * turn)))
        assert min(off) < 1e-6


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.booleans())
def test_twists_are_the_derivatives_of_the_poses(seed, stamped):
    poses = random_poses(seed, 3)
    if stamped:
        lines, duration = stamped_path(poses, np.array([0.0, 1.5, 4.0])), 4.0
    else:
        lines, duration = speed_path(poses, 0.2)
    h = 1e-4
    t = np.linspace(0.01, duration - 0.01, 40)
    before, now, after = lines(t - h), lines(t), lines(t + h)
    for i in range(t.size):
        assert_allclose(twist_of(before.pose[i], after.pose[i], 2 * h), now.twist[i], atol=1e-4)
    assert_allclose((after.twist - before.twist) / (2 * h), now.twist_rate, atol=1e-2)


@settings(max_examples=25)
@given(st.lists(st.floats(0.1, 3.0), min_size=2, max_size=6), st.integers(0, 1000))
def test_on_one_line_it_passes_without_stopping_and_never_runs_back(spans, seed):
    times = np.concatenate([[0.0], np.cumsum(spans)])
    poses = np.tile(random_poses(seed, 1), (times.size, 1, 1))
    poses[:, 0, 3] += 0.05 * np.arange(times.size)
    lines = stamped_path(poses, times)
    assert_allclose(lines(times).pose[:, 0, 3], poses[:, 0, 3], atol=1e-12)
    assert np.all(lines(times[1:-1]).twist[:, 0] > 0.0)
    assert np.all(lines(np.linspace(0.0, times[-1], 500)).twist[:, 0] >= -1e-12)


def test_the_tool_keeps_its_speed_between_the_corners():
    poses = np.tile(random_poses(1, 1), (3, 1, 1))
    poses[1, 0, 3] += 0.3
    poses[2, 0, 3] += 0.3
    poses[2, 1, 3] += 0.3
    lines, duration = speed_path(poses, 0.1)
    speed = np.linalg.norm(lines(np.linspace(0.0, duration, 1000)).twist[:, :3], axis=1)
    assert_allclose(speed.max(), 0.1, rtol=1e-12)
    assert np.sum(np.isclose(speed, 0.1)) > 750
    assert speed.min() < 1e-3


def test_a_turn_on_the_spot_is_timed_too():
    poses = np.array([np.eye(4), pose_matrix([0, 0, 0], [0, 0, np.sin(0.5), np.cos(0.5)])])
    lines, duration = speed_path(poses, 0.1)
    assert_allclose(lines.length, TURN_LENGTH)  # one radian
    assert_allclose(lines(np.array([duration / 2])).twist[0, 5], 0.1 / TURN_LENGTH)


def test_a_half_turn_goes_about_a_definite_axis():
    poses = np.array([np.eye(4), pose_matrix([0.1, 0, 0], [0.6, 0.8, 0.0, 0.0])])
    lines = stamped_path(poses, np.array([0.0, 1.0]))
    assert_allclose(lines(np.array([1.0])).pose[0], poses[1], atol=1e-12)


def test_equal_poses_are_a_pause():
    poses = np.tile(random_poses(2, 1), (4, 1, 1))
    poses[2:, 0, 3] += 0.1
    lines = stamped_path(poses, np.array([0.0, 1.0, 2.0, 3.0]))
    samples = lines(np.array([0.5, 2.5]))
    assert_allclose(samples.pose, poses[[0, 3]], atol=1e-12)
    assert_allclose(samples.twist, 0.0, atol=1e-12)
    still, duration = speed_path(poses[:2], 0.1)
    assert duration == 0.0
    assert_allclose(still(np.zeros(1)).pose[0], poses[0])


def straight(*offsets, pose=None):
    start = forward_kinematics(HOME, ARM) if pose is None else pose
    poses = np.tile(start, (len(offsets), 1, 1))
    poses[:, :3, 3] += np.array(offsets)
    return poses


def test_a_path_is_approached_followed_and_held(holding, close_loop):
    controller, plant = holding(HOME + 0.2, 500)
    poses = straight([0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0])
    controller.path(poses, [5 * S, 7 * S, 9 * S])
    run = close_loop(controller, plant, 500 * 7)
    reached = forward_kinematics(run.reference, ARM)[:, :3, 3]
    corners = poses[:, :3, 3]
    gap = np.linalg.norm(reached[:, None] - corners, axis=2)
    at = gap.argmin(axis=0)
    assert_allclose(gap.min(axis=0), 0.0, atol=1e-6)
    assert_allclose(np.diff(at), 1000, atol=1)  # two seconds apart
    assert run.status[-1] == 'holding'
    assert np.linalg.norm(forward_kinematics(run.q[-1], ARM)[:3, 3] - corners[-1]) < 1e-4
    on_the_way = reached[at[0]:at[1]]
    assert np.abs(on_the_way[:, 1:] - corners[0, 1:]).max() < 1e-9


@pytest.mark.parametrize(('offsets', 'stamps', 'words'), [
    ([[0, 0, 0]], [0], 'the path has 1 pose'),
    ([[0, 0, 0], [0.1, 0, 0]], [S, S // 2], 'pose 2 has the time -0.500000 s'),
    ([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], [0, S, S], 'give increasing stamps'),
    ([[0, 0, 0], [-2.0, 0, 0]], [0, 0], r'sample \d+ of \d+ \(t = .* out of reach'),
    ([[0, 0, 0], [0, 0, 0.9]], [0, 0], r'sample \d+ of \d+ \(t = .*(out of reach|singularity)'),
    ([[0, 0, 0], [0.2, 0, 0]], [0, S // 10], r'sample \d+ .* rad/s; its limit is'),
    ([[0, 0, 0], [0.1, 0, 0]], [0, 10_000 * S], 'the path takes 10000.0 s'),
    ([[0, 0, 0], [0.1, 0, 0]], [0, S, 2 * S], '3 stamps for 2 poses'),
])
def test_a_path_that_cannot_be_followed_is_refused_before_the_arm_moves(
        holding, close_loop, offsets, stamps, words):
    controller, plant = holding(HOME, 500)
    with pytest.raises(InputError, match=words):
        controller.path(straight(*offsets), stamps)
    run = close_loop(controller, plant, 10)
    assert_allclose(run.reference, np.tile(HOME, (10, 1)), atol=0.0)
    assert run.status[-1] == 'refused'


def test_a_path_that_begins_beyond_max_joint_jump_is_refused(holding):
    controller, _ = holding(HOME + [2.0, 0, 0, 0, 0, 0], 500, max_joint_jump=1.0)
    with pytest.raises(InputError, match=r'would have to turn by 2\.0000 rad to the first pose'):
        controller.path(straight([0, 0, 0], [0.1, 0, 0]), [0, 0])


@pytest.mark.fault(24)
def test_a_path_through_the_wrist_singularity_is_refused(holding):
    begin = np.deg2rad([0.0, -75.0, 90.0, -105.0, 30.0, 0.0])
    end = begin.copy()
    end[4] = -begin[4]  # the same tool, turned through sin q5 = 0
    controller, _ = holding(begin, 500)
    poses = forward_kinematics(np.array([begin, end]), ARM)
    with pytest.raises(InputError, match=r'sample \d+ of \d+ .*(singularity|branch)'):
        controller.path(poses, [0, 0])


def test_a_path_in_base_link_is_turned_by_half_a_turn(holding):
    controller, _ = holding(HOME, 500)
    turned = np.diag([-1.0, -1.0, 1.0, 1.0])
    poses = np.matmul(turned, straight([0, 0, 0], [0.05, 0, 0]))
    controller.path(poses, [0, 0], 'base_link')
    assert controller.status()['state'] == 'moving'
    with pytest.raises(InputError, match="frame 'world' is not known"):
        controller.path(poses, [0, 0], 'world')
