import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.point_to_point import MotionLimits, point_to_point, smooth_stop
from ur5_ros.errors import InputError
from ur5_ros.signals import Reference

ARM = load_arm('ur5')
LIMITS = MotionLimits(np.full(6, 1.0), np.full(6, 2.0), np.full(6, 20.0))
six = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(np.array)


def samples(motion, step=1_000_000):
    times = np.arange(0, motion.duration + 2 * step, step)
    rows = [motion.at(int(time)) for time in times]
    return tuple(np.array(part) for part in zip(*rows, strict=True))


@settings(max_examples=40)
@given(six, six, six, six)
def test_a_motion_takes_over_any_reference_and_ends_at_rest_at_the_target(q, qd, qdd, target):
    start = Reference(q, 0.4 * qd, 0.8 * qdd)
    motion = point_to_point(start, target, LIMITS, ARM)
    for part, expected in zip(motion.at(0), start, strict=True):
        assert_allclose(part, expected, atol=1e-12)
    end = motion.at(motion.duration)
    assert_allclose(end.q, target, atol=0.0)
    assert not end.qd.any()
    assert not end.qdd.any()
    q, qd, qdd = samples(motion, 5_000_000)
    h = 5e-3
    # continuous: no step is larger than speed, acceleration and jerk explain
    assert np.abs(np.diff(q, axis=0)).max() <= 1.3 * h
    assert np.abs(np.diff(qd, axis=0)).max() <= 2.0 * h + 1e-9
    assert np.abs(np.diff(qdd, axis=0)).max() <= 20.0 * h + 1e-6


@settings(max_examples=40)
@given(six, six)
def test_from_rest_no_limit_is_passed_and_no_joint_overshoots(q, target):
    still = Reference(q, np.zeros(6), np.zeros(6))
    q_way, qd, qdd = samples(point_to_point(still, target, LIMITS, ARM), 5_000_000)
    assert np.abs(qd).max() <= 1.0 + 1e-9
    assert np.abs(qdd).max() <= 2.0 + 1e-9
    assert np.all(q_way <= np.maximum(q, target) + 1e-9)
    assert np.all(q_way >= np.minimum(q, target) - 1e-9)


@settings(max_examples=40)
@given(six, six, six)
def test_a_stop_ends_at_rest_without_a_jump(q, qd, qdd):
    start = Reference(q, qd, qdd)
    motion = smooth_stop(start, LIMITS)
    for part, expected in zip(motion.at(0), start, strict=True):
        assert_allclose(part, expected, atol=1e-12)
    q, qd, _ = samples(motion, 5_000_000)
    assert_allclose(qd[-1], 0.0, atol=0.0)
    assert np.abs(np.diff(qd, axis=0)).max() <= 2.0 * 5e-3 + 1e-9
    assert np.abs(np.diff(q, axis=0)).max() <= 3.2 * 5e-3


def test_staying_where_one_is_takes_no_time():
    still = Reference(np.ones(6), np.zeros(6), np.zeros(6))
    assert point_to_point(still, np.ones(6), LIMITS, ARM).duration == 0
    assert smooth_stop(still, LIMITS).duration == 0


@pytest.mark.fault(24)
def test_a_target_beyond_a_limit_is_refused_by_name():
    still = Reference(np.zeros(6), np.zeros(6), np.zeros(6))
    words = 'elbow_joint would go to 6.5000 rad; its limits are -6.2832'
    with pytest.raises(InputError, match=words):
        point_to_point(still, np.array([0.0, 0.0, 6.5, 0.0, 0.0, 0.0]), LIMITS, ARM)


def test_a_way_that_shoots_beyond_a_limit_is_refused():
    fast = Reference(np.full(6, 6.2), np.full(6, 1.0), np.zeros(6))
    with pytest.raises(InputError, match='would go to'):
        point_to_point(fast, np.full(6, 6.1), LIMITS, ARM)


def test_a_start_that_nothing_can_stop_is_refused_in_one_line():
    mad = Reference(np.zeros(6), np.array([0, 0, 0, 0, 0, 1e9]), np.zeros(6))
    with pytest.raises(InputError, match='from 1e.09 rad/s of wrist_3_joint; ask again from rest'):
        smooth_stop(mad, LIMITS)


def test_continuous_joints_go_as_far_as_one_likes():
    still = Reference(np.zeros(6), np.zeros(6), np.zeros(6))
    target = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 50.0])
    motion = point_to_point(still, target, LIMITS, load_arm('ur3e'))
    assert_allclose(motion.at(motion.duration).q, target)
