"""Rotations in all their forms, beside Pinocchio's."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.model.rotations import (
    position_and_quaternion,
    quaternion_of,
    rotation_about,
    rotation_of_quaternion,
    rotation_of_rpy,
    rotation_vector,
)

directions = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array).filter(
    lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))
angles = st.one_of(st.floats(0.0, np.pi), st.sampled_from(
    [0.0, 1e-12, 1e-6, np.pi / 2, np.pi - 1e-6, np.pi - 1e-9, np.pi]))


@given(directions, angles)
def test_axis_and_angle_give_the_rotation_of_pinocchio(axis, angle):
    assert_allclose(rotation_about(axis, angle), pin.exp3(axis * angle), atol=1e-14)


@given(directions, angles)
def test_the_quaternion_of_any_rotation_turns_as_its_matrix_does(axis, angle):
    rotation = pin.exp3(axis * angle)
    quaternion = quaternion_of(rotation)
    assert quaternion[3] >= 0.0
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=1e-15)
    assert_allclose(pin.Quaternion(quaternion).toRotationMatrix(), rotation, atol=1e-14)
    assert_allclose(rotation_of_quaternion(quaternion), rotation, atol=1e-14)


@given(directions, angles)
def test_the_rotation_vector_is_accurate_at_every_angle(axis, angle):
    vector, = rotation_vector(pin.exp3(axis * angle)[None])
    assert_allclose(pin.exp3(vector), pin.exp3(axis * angle), atol=1e-14)
    assert np.linalg.norm(vector) == pytest.approx(angle, abs=1e-14)
    if angle < 3.0:
        assert_allclose(vector, axis * angle, atol=1e-14)


@given(*[st.floats(-4.0, 4.0)] * 3)
def test_roll_pitch_and_yaw_are_those_of_pinocchio(roll, pitch, yaw):
    assert_allclose(rotation_of_rpy(roll, pitch, yaw), pin.rpy.rpyToMatrix(roll, pitch, yaw),
                    atol=1e-15)


def test_many_rotations_equal_one_after_the_other_to_the_bit():
    random = np.random.default_rng(3)
    vectors = random.uniform(-2.0, 2.0, (50, 3))
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / angle[:, None]
    many = rotation_about(axis, angle)
    assert_allclose(rotation_vector(many)[angle < np.pi], vectors[angle < np.pi], atol=1e-13)
    for i in range(50):
        assert rotation_about(axis[i], angle[i]).tobytes() == many[i].tobytes()
        assert rotation_vector(many[i:i + 1]).tobytes() == rotation_vector(many)[i].tobytes()
    assert (rotation_of_rpy(*vectors.T)[7].tobytes()
            == rotation_of_rpy(*vectors[7]).tobytes())


def test_a_pose_is_given_as_a_message_holds_it():
    transform = pin.SE3(pin.exp3(np.array([0.1, -0.2, 0.3])), np.array([1.0, 2.0, 3.0]))
    position, quaternion = position_and_quaternion(transform.homogeneous)
    assert position.tolist() == [1.0, 2.0, 3.0]
    assert_allclose(quaternion, pin.Quaternion(transform.rotation).coeffs(), atol=1e-15)
