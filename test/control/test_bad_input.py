"""Whatever is asked, the answer is a motion or a refusal in one line; the arm keeps holding."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ur5_ros.config.parameters import CONTROL_PARAMETERS
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.targets import pose_matrix
from ur5_ros.control.tolerances import JointTolerance
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES, ArmState

HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
ZERO = np.zeros(6)
wild = st.one_of(st.floats(-4.0, 4.0), st.floats(), st.sampled_from([0.0, 1.0, 1e308, -1e-308]))
numbers = st.lists(wild, max_size=8)
six = st.lists(wild, min_size=6, max_size=6)
names = st.one_of(st.just(list(JOINT_NAMES)), st.permutations(JOINT_NAMES),
                  st.lists(st.sampled_from([*JOINT_NAMES, 'gripper', '']), max_size=8))
times = st.one_of(st.integers(0, 5_000_000_000), st.integers(-2**63, 2**63))
points = st.lists(st.builds(
    TrajectoryPoint, times, st.one_of(six, numbers), st.one_of(st.just([]), numbers, six),
    st.one_of(st.just([]), numbers, six)), max_size=5)
tolerances = st.lists(st.builds(JointTolerance, st.sampled_from([*JOINT_NAMES, 'x']), wild, wild),
                      max_size=3)


def asked(wish):
    """Ask a controller that holds; check that it answers all the same."""
    controller = controller_from_parameters({}, 500)
    controller.update(ArmState(2_000_000, HOME, ZERO, ZERO))
    before = controller.status()['refused_inputs']
    refused = False
    try:
        wish(controller)
    except InputError as refusal:
        refused = True
        assert str(refusal)
        assert '\n' not in str(refusal)
    q = HOME
    for k in range(2, 40):
        answer = controller.update(ArmState(k * 2_000_000, q, ZERO, ZERO))
        assert np.all(np.isfinite(answer.torque.total))
        if refused:
            assert answer.reference.q.tobytes() == HOME.tobytes()
        assert np.abs(answer.reference.q - q).max() < 0.02
        q = answer.reference.q
    return controller.status()['refused_inputs'] - before


@settings(max_examples=80)
@given(names, st.one_of(six, numbers))
def test_any_joint_target(names, positions):
    asked(lambda controller: controller.target_joints(names, positions))


@pytest.mark.fault(23)
@settings(max_examples=80)
@given(st.lists(wild, min_size=3, max_size=3), st.lists(wild, min_size=4, max_size=4),
       st.sampled_from(['base', 'base_link', 'world', '']))
def test_any_pose(position, quaternion, frame):
    asked(lambda controller: controller.target_pose(pose_matrix(position, quaternion), frame))


@settings(max_examples=80)
@given(st.lists(wild, min_size=16, max_size=16))
def test_any_matrix(elements):
    asked(lambda controller: controller.target_pose(np.reshape(elements, (4, 4))))


@settings(max_examples=120)
@given(names, points, st.one_of(st.just(0), times))
def test_any_trajectory(names, points, stamp):
    asked(lambda controller: controller.joint_trajectory(names, points, stamp))


@settings(max_examples=60)
@given(names, points, tolerances, tolerances, wild)
def test_any_goal(names, points, path, goal, time):
    asked(lambda controller: controller.follow_joint_trajectory(
        names, points, 0, path, goal, time))


@settings(max_examples=60)
@given(st.lists(st.tuples(st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3), times),
                max_size=4), st.booleans())
def test_any_path(stations, stamped):
    poses = np.array([pose_matrix(position, [0.0, 1.0, 0.0, 0.0]) for position, _ in stations])
    stamps = [stamp if stamped else 0 for _, stamp in stations]
    asked(lambda controller: controller.path(poses.reshape(-1, 4, 4), stamps))


@settings(max_examples=80)
@given(st.sampled_from([parameter.name for parameter in CONTROL_PARAMETERS]),
       st.one_of(wild, st.text(max_size=3), st.booleans(), st.lists(wild, max_size=7), st.none()))
def test_any_parameter(name, value):
    asked(lambda controller: controller.change({name: value}))


@settings(max_examples=80)
@given(st.lists(st.tuples(st.integers(0, 3_000_000_000), six, six), min_size=1, max_size=8))
def test_any_sequence_of_states(rows):
    controller = controller_from_parameters({'experiment': '', 'max_state_jump': 0.5}, 500)
    for stamp, q, qd in rows:
        state = ArmState(stamp, np.array(q), np.array(qd), ZERO)
        try:
            answer = controller.update(state)
        except InputError as refusal:
            assert 'not answered' in str(refusal)
            continue
        assert np.all(np.abs(answer.torque.total) <= controller.arm.limits.effort * (1 + 1e-12))
