"""Goals judged as the joint_trajectory_controller judges them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.tolerances import (
    JointTolerance,
    ResultCode,
    default_tolerances,
    judge,
    resolve_tolerances,
)
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

S = 1_000_000_000
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
ZERO = np.zeros(6)
DEFAULT = default_tolerances(0.2, 0.1, 2.0)


def error(position=0.0, velocity=0.0):
    rows = np.full((3, 6), np.nan)
    rows[:2] = 0.0
    rows[0, 2], rows[1, 2] = position, velocity
    return rows


def test_codes_are_those_of_control_msgs():
    assert [code.value for code in ResultCode] == [0, -1, -2, -3, -4, -5]


@pytest.mark.parametrize(('position', 'velocity', 'past_end', 'code'), [
    (0.19, 9.0, -1.0, None),  # on the path: within 0.2 rad, speed not judged
    (0.21, 0.0, -1.0, ResultCode.PATH_TOLERANCE_VIOLATED),
    (-0.21, 0.0, -1e-9, ResultCode.PATH_TOLERANCE_VIOLATED),
    (0.09, 0.0, 0.0, ResultCode.SUCCESSFUL),
    (0.11, 0.0, 0.0, None),  # not there yet, two seconds to go
    (0.09, 0.3, 1.0, None),  # there, still moving
    (0.11, 0.0, 2.0, None),
    (0.11, 0.0, 2.001, ResultCode.GOAL_TOLERANCE_VIOLATED),
    (0.09, 0.0, 99.0, ResultCode.SUCCESSFUL),
])
def test_path_and_goal_are_judged_at_their_time(position, velocity, past_end, code):
    verdict = judge(DEFAULT, error(position, velocity), past_end)
    assert (verdict and verdict.code) == code
    if code in (ResultCode.PATH_TOLERANCE_VIOLATED, ResultCode.GOAL_TOLERANCE_VIOLATED):
        assert f'elbow_joint has a position error of {abs(position):g} rad' in verdict.message


def test_zero_keeps_the_default_and_minus_one_removes_the_limit():
    tolerances = resolve_tolerances(
        DEFAULT,
        path=[JointTolerance('elbow_joint', -1.0, 0.5)],
        goal=[JointTolerance('wrist_3_joint', 0.01, -1.0)],
        goal_time=-1.0)
    assert_allclose(tolerances.path[0], [0.2, 0.2, np.inf, 0.2, 0.2, 0.2])
    assert tolerances.path[1, 2] == 0.5
    assert_allclose(tolerances.goal[0], [0.1] * 5 + [0.01])
    assert tolerances.goal[1, 5] == np.inf
    assert tolerances.goal_time == np.inf
    assert resolve_tolerances(DEFAULT).goal_time == 2.0
    assert_allclose(DEFAULT.path[0], 0.2)  # the default itself is left alone


@pytest.mark.parametrize(('given', 'words'), [
    ({'path': [JointTolerance('elbow')]}, "path_tolerance names 'elbow'"),
    ({'goal': [JointTolerance('elbow_joint', -2.0)]}, 'goal_tolerance of elbow_joint is -2'),
    ({'goal_time': float('nan')}, 'goal_time_tolerance is nan'),
])
def test_wrong_tolerances_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        resolve_tolerances(DEFAULT, **given)


def test_zero_constraints_mean_no_limit():
    free = default_tolerances(0.0, 0.0, 0.0)
    assert judge(free, error(1e9), -1.0) is None
    assert judge(free, error(1e9), 0.0).code == ResultCode.SUCCESSFUL


def goal(seconds=1.0, step=0.3):
    return JOINT_NAMES, [TrajectoryPoint(round(seconds * S), (HOME + step).tolist(), [0.0] * 6)]


def test_a_goal_that_is_reached_succeeds(holding, close_loop):
    controller, plant = holding(HOME)
    number = controller.follow_joint_trajectory(*goal())
    close_loop(controller, plant, 400)
    assert controller.goal_verdict(number) is None
    close_loop(controller, plant, 150)
    assert controller.goal_verdict(number).code == ResultCode.SUCCESSFUL


def test_an_arm_pushed_off_the_path_aborts_and_holds(holding, close_loop):
    controller, plant = holding(HOME)
    number = controller.follow_joint_trajectory(*goal(3.0))
    close_loop(controller, plant, 500)
    plant.q[1] += 0.25
    run = close_loop(controller, plant, 3000)
    verdict = controller.goal_verdict(number)
    assert verdict.code == ResultCode.PATH_TOLERANCE_VIOLATED
    assert 'shoulder_lift_joint has a position error of 0.25' in verdict.message
    assert run.status[-1] == 'holding'
    assert np.abs(run.reference[-1] - HOME).max() < 0.2  # stopped on the way
    assert np.abs(np.diff(run.reference_qd, axis=0)).max() <= 2.0 / 500 + 1e-9


def test_a_goal_missed_for_the_goal_time_aborts(holding, close_loop, exact_arm):
    controller, plant = holding(HOME, constraints__goal_time=0.5)
    number = controller.follow_joint_trajectory(
        *goal(), goal_tolerance=[JointTolerance('wrist_2_joint', 1e-9)])
    run = close_loop(controller, plant, 740)
    assert controller.goal_verdict(number) is None
    run = close_loop(controller, plant, 20)
    assert controller.goal_verdict(number).code == ResultCode.GOAL_TOLERANCE_VIOLATED
    assert run.status[-1] == 'holding'


@pytest.mark.parametrize('by', ['hold', 'target_joints', 'follow_joint_trajectory'])
def test_a_goal_is_preempted_by_anything_newer(holding, close_loop, by):
    controller, plant = holding(HOME)
    number = controller.follow_joint_trajectory(*goal())
    close_loop(controller, plant, 100)
    wishes = {'hold': (), 'target_joints': (JOINT_NAMES, HOME),
              'follow_joint_trajectory': goal()}
    getattr(controller, by)(*wishes[by])
    assert controller.goal_verdict(number).code == ResultCode.INVALID_GOAL
    assert 'preempted by' in controller.goal_verdict(number).message


def test_a_refused_goal_leaves_the_one_that_is_on(holding, close_loop):
    controller, plant = holding(HOME)
    number = controller.follow_joint_trajectory(*goal())
    with pytest.raises(InputError):
        controller.follow_joint_trajectory(JOINT_NAMES, [])
    close_loop(controller, plant, 600)
    assert controller.goal_verdict(number).code == ResultCode.SUCCESSFUL
