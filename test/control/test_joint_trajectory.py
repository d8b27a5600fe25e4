"""The rules of the joint_trajectory_controller, and a takeover without a jump."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import BPoly, CubicHermiteSpline

from ur5_ros.config import load_arm
from ur5_ros.control.joint_trajectory import TrajectoryPoint, check_points, joint_spline
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES, Reference

ARM = load_arm('ur5')
S = 1_000_000_000
ORDER = list(range(6))
ZERO = np.zeros(6)
STILL = Reference(ZERO, ZERO, ZERO)
six = st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6).map(np.array)


def point(time, q, v=(), a=()):
    return TrajectoryPoint(round(time * S), list(q), list(v), list(a))


def sample(motion, times):
    rows = [motion.at(round(time * S)) for time in times]
    return tuple(np.array(part) for part in zip(*rows, strict=True))


@settings(max_examples=30)
@given(six, six, six, six)
def test_with_velocities_it_is_the_cubic_spline(q1, v1, q2, v2):
    motion = joint_spline([point(1, q1, v1), point(3, q2, v2), point(4, ZERO, ZERO)], ORDER,
                          STILL, 0, ARM)
    witness = CubicHermiteSpline([0, 1, 3, 4], [ZERO, q1, q2, ZERO], [ZERO, v1, v2, ZERO])
    t = np.linspace(0.0, 3.999, 50)
    q, qd, qdd = sample(motion, t)
    assert_allclose(q, witness(t), atol=1e-9)
    assert_allclose(qd, witness(t, 1), atol=1e-8)


@settings(max_examples=30)
@given(six, six, six, six, six, six)
def test_with_accelerations_it_is_the_quintic_spline(q0, v0, a0, q1, v1, a1):
    points = [point(1, q1, v1, a1), point(2.5, ZERO, ZERO, ZERO)]
    motion = joint_spline(points, ORDER, Reference(q0, v0, a0), 0, ARM)
    witness = BPoly.from_derivatives(
        [0, 1, 2.5], [[q0, v0, a0], [q1, v1, a1], [ZERO, ZERO, ZERO]])
    t = np.linspace(0.0, 2.499, 50)
    q, qd, qdd = sample(motion, t)
    assert_allclose(q, witness(t), atol=1e-9)
    assert_allclose(qd, witness(t, nu=1), atol=1e-8)
    assert_allclose(qdd, witness(t, nu=2), atol=1e-7)


def test_with_positions_only_it_is_linear_after_the_takeover():
    motion = joint_spline([point(2, ZERO + 0.2), point(3, ZERO + 0.4), point(5, ZERO)], ORDER,
                          STILL, 0, ARM)
    t = np.array([1.5, 2.0, 2.5, 3.0, 4.0, 5.0])
    q, qd, _ = sample(motion, t)
    assert_allclose(q[:, 0], [0.15, 0.2, 0.3, 0.4, 0.2, 0.0], atol=1e-12)
    assert_allclose(qd[:, 0], [0.1, 0.2, 0.2, -0.2, -0.2, 0.0], atol=1e-12)
    assert_allclose(sample(motion, [0.0])[1], 0.0, atol=1e-12)  # starts at rest all the same


def test_joints_are_matched_by_name():
    order = [5, 4, 3, 2, 1, 0]
    motion = joint_spline([point(9, [6, 5, 4, 3, 2, 1], [0] * 6)], order, STILL, 0, ARM)
    assert_allclose(motion.at(motion.duration).q, [1, 2, 3, 4, 5, 6])


def test_a_first_point_due_now_and_near_is_bridged_not_jumped_to():
    start = Reference(ZERO + 0.02, ZERO + 0.3, ZERO)
    points = [point(0, ZERO, ZERO), point(1, ZERO + 0.5, ZERO)]
    motion = joint_spline(points, ORDER, start, 0, ARM)
    assert_allclose(motion.at(0).q, start.q, atol=1e-12)
    assert_allclose(motion.at(0).qd, start.qd, atol=1e-12)
    assert_allclose(motion.at(S).q, 0.5)
    q, qd, _ = sample(motion, np.linspace(0, 1, 1001))
    assert np.abs(np.diff(qd, axis=0)).max() < 0.02


def test_a_first_point_due_now_and_far_is_refused():
    with pytest.raises(InputError, match=r'would jump by 0\.5000 rad; at most 0\.1 is bridged'):
        joint_spline([point(0, ZERO + 0.5, ZERO), point(1, ZERO, ZERO)], ORDER, STILL, 0, ARM)


def test_a_trajectory_begun_in_the_past_is_joined_where_it_is_now():
    points = [point(0, ZERO, ZERO), point(2, ZERO + 1.0, ZERO), point(3, ZERO, ZERO)]
    whole = joint_spline(points, ORDER, STILL, 0, ARM)
    for late in (0.5, 2.25):
        now = whole.at(round(late * S))
        joined = joint_spline(points, ORDER, now, -round(late * S), ARM)
        assert joined.duration == whole.duration - round(late * S)
        for t in np.linspace(0.0, 3.0 - late, 20):
            assert_allclose(joined.at(round(t * S)).q, whole.at(round((t + late) * S)).q,
                            atol=1e-9)


def test_a_trajectory_stamped_ahead_is_reached_at_its_time():
    motion = joint_spline([point(1, ZERO + 1.0, ZERO)], ORDER, STILL, 2 * S, ARM)
    assert motion.duration == 3 * S
    assert_allclose(motion.at(3 * S).q, 1.0)


def test_too_fast_or_too_far_is_refused_with_joint_and_time():
    with pytest.raises(InputError, match=r'shoulder_pan_joint at .* rad/s; its limit is 3\.142'):
        joint_spline([point(0.2, [1.0, 0, 0, 0, 0, 0], ZERO)], ORDER, STILL, 0, ARM)
    with pytest.raises(InputError, match='wrist_3_joint at .* rad; its limits'):
        joint_spline([point(9, [0, 0, 0, 0, 0, 7.0], ZERO)], ORDER, STILL, 0, ARM)


GOOD = [point(1, ZERO, ZERO), point(2, ZERO, ZERO)]


@pytest.mark.parametrize(('points', 'stamp', 'words'), [
    ([], 0, 'no points'),
    ([GOOD[0], GOOD[0]], 0, 'point 2 has time_from_start 1.0 s, point 1 1.0 s'),
    ([GOOD[1], GOOD[0]], 0, 'strictly increase'),
    ([point(-1, ZERO, ZERO)], 0, 'time_from_start -1.0 s'),
    ([point(1, [0.0] * 5)], 0, 'point 1 has 5 positions for 6 joints'),
    ([point(1, [])], 0, 'point 1 has 0 positions'),
    ([point(1, ZERO, [0.0] * 3)], 0, '3 velocities'),
    ([point(1, ZERO, ZERO, [0.0])], 0, '1 accelerations'),
    ([point(1, [np.nan] * 6)], 0, 'finite'),
    ([point(1, ZERO, [np.inf] + [0.0] * 5)], 0, 'finite'),
    ([GOOD[0]._replace(effort=[1.0] * 6)], 0, 'efforts'),
    ([point(1, ZERO, [0.1] + [0.0] * 5)], 0, 'last point has a velocity of 0.1'),
    (GOOD, 7 * S, 'ended 1.000 s ago'),
])
def test_what_the_joint_trajectory_controller_refuses_is_refused(points, stamp, words):
    with pytest.raises(InputError, match=words):
        check_points(points, 6, stamp, 10 * S, False)


def test_what_it_accepts_is_accepted():
    check_points(GOOD, 6, 0, 10 * S, False)
    check_points(GOOD, 6, 8 * S, 10 * S, False)  # ends now
    check_points([point(0, ZERO, ZERO), GOOD[0]], 6, 0, 10 * S, False)  # the first may be 0
    check_points([point(1, ZERO, ZERO + 0.1)], 6, 0, 10 * S, True)


def test_a_newer_trajectory_replaces_the_older_and_wrong_names_are_refused(holding, close_loop):
    controller, plant = holding(ZERO - 1.0)
    controller.joint_trajectory(JOINT_NAMES, [point(5, ZERO, ZERO)])
    close_loop(controller, plant, 500)
    controller.joint_trajectory(JOINT_NAMES[::-1], [point(1, ZERO - 1.0, ZERO)])
    with pytest.raises(InputError, match="unknown joint 'joint_7'"):
        controller.joint_trajectory([*JOINT_NAMES[:5], 'joint_7'], [point(1, ZERO, ZERO)])
    with pytest.raises(InputError, match='joint wrist_3_joint is missing'):
        controller.joint_trajectory(JOINT_NAMES[:5], [point(1, ZERO[:5], ZERO[:5])])
    run = close_loop(controller, plant, 600)
    assert_allclose(run.reference[-1], -1.0)
    assert run.status[-1] == 'refused'  # at rest, the newest wish not granted


def test_an_allowed_end_velocity_is_brought_to_rest_smoothly(holding, close_loop):
    controller, plant = holding(ZERO - 1.0, allow_nonzero_velocity_at_trajectory_end=True)
    controller.joint_trajectory(JOINT_NAMES, [point(1, ZERO - 0.5, ZERO + 0.5)])
    run = close_loop(controller, plant, 1500)
    assert np.abs(np.diff(run.reference_qd, axis=0)).max() < 0.02
    assert run.status[-1] == 'holding'
