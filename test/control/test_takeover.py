"""Whatever takes over from whatever: the reference jumps neither in position nor in velocity."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.signals import JOINT_NAMES, ArmState

RATE = 500
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
LAW = controller_from_parameters({'experiment': 'multi_sine'}, RATE)


def steer(controller, wish, rng):
    """Ask for something at random."""
    near = HOME + rng.uniform(-0.3, 0.3, 6)
    arm = controller.arm
    if wish == 'joints':
        controller.target_joints(JOINT_NAMES, near)
    elif wish == 'pose':
        controller.target_pose(forward_kinematics(near, arm))
    elif wish == 'path':
        pose = forward_kinematics(near, arm)
        second = pose.copy()
        second[:3, 3] += [0.03, 0.02, 0.0]
        controller.path(np.array([pose, second]), [0, 0])
    elif wish == 'hold':
        controller.hold()
    elif wish == 'experiment':
        controller.start_experiment()
    else:
        fields = {'linear': 1, 'cubic': 2, 'quintic': 3}[wish]
        points = [TrajectoryPoint(1_000_000_000 * (i + 1), *[
            (HOME + rng.uniform(-0.3, 0.3, 6)).tolist(), [0.0] * 6, [0.0] * 6][:fields])
            for i in range(2)]
        controller.joint_trajectory(JOINT_NAMES, points)


WISHES = ('joints', 'pose', 'path', 'hold', 'experiment', 'linear', 'cubic', 'quintic')


@pytest.mark.fault(25)
@settings(max_examples=60)
@given(st.lists(st.sampled_from(WISHES), min_size=2, max_size=4), st.integers(0, 10_000))
def test_no_target_makes_the_reference_jump(wishes, seed):
    rng = np.random.default_rng(seed)
    controller = controller_from_parameters({}, RATE)
    controller.experiment = LAW.experiment  # its table costs more than the rest
    zero, answers, marks = np.zeros(6), [], []
    q, k = HOME, 0
    for wish in wishes:
        for _ in range(rng.integers(1, 400)):
            k += 1
            answers.append(controller.update(ArmState(k * 2_000_000, q, zero, zero)))
            q = answers[-1].reference.q  # an arm without error
        steer(controller, wish, rng)
        marks.append(len(answers) - 1)
    for _ in range(100):
        k += 1
        answers.append(controller.update(ArmState(k * 2_000_000, q, zero, zero)))
        q = answers[-1].reference.q
    h = 1.0 / RATE
    for i in marks:
        before, after = answers[i].reference, answers[i + 1].reference
        assert np.abs(after.q - before.q - before.qd * h).max() < 1e-4  # 25 rad/s^2 at most
        assert np.abs(after.qd - before.qd).max() < 0.04


def test_hold_stops_a_motion_smoothly_and_keeps_the_arm_there(holding, close_loop):
    controller, plant = holding(HOME, RATE)
    controller.target_joints(JOINT_NAMES, HOME + 1.0)
    close_loop(controller, plant, RATE // 2)
    controller.hold()
    run = close_loop(controller, plant, 6 * RATE)
    assert run.status[0] == 'moving'
    assert run.status[-1] == 'holding'
    assert not run.reference_qd[-1].any()
    assert np.abs(np.diff(run.reference_qd, axis=0)).max() * RATE <= 2.0 + 1e-6
    assert_allclose(run.q[-1], run.reference[-1], atol=1e-4)


def test_an_experiment_that_ends_at_speed_is_brought_to_rest(close_loop, exact_arm, tmp_path):
    # the paper's profile is still moving after its 20 s
    controller = controller_from_parameters({'experiment': 'kebria_fig11', 'autostart': True}, 250)
    plant = exact_arm(controller.arm, 250, controller.experiment.trajectory.at(0).q)
    run = close_loop(controller, plant, 250 * 23)
    speed = np.abs(run.reference_qd).max(axis=1)
    assert speed[20 * 250] > 0.1
    assert speed[-1] == 0.0
    assert np.abs(np.diff(run.reference_qd, axis=0)).max() * 250 <= 2.0 + 1e-6
    assert run.status[-1] == 'holding'


def test_an_experiment_on_demand_begins_where_the_arm_is(holding, close_loop):
    controller, plant = holding(HOME + 0.4, RATE, experiment='joint_step')
    controller.start_experiment()
    run = close_loop(controller, plant, 12 * RATE)
    assert_allclose(run.reference[0], HOME + 0.4, atol=1e-4)
    assert_allclose(run.reference[-1], HOME + 0.2, atol=1e-12)
    steps = np.abs(np.diff(run.reference, axis=0)).max(axis=1)
    assert np.sum(steps > 0.01) == 1  # the step that the experiment is about


def test_an_autostarted_experiment_far_away_is_approached_first(exact_arm, close_loop):
    controller = controller_from_parameters({'experiment': 'joint_step', 'autostart': True}, RATE)
    run = close_loop(controller, exact_arm(controller.arm, RATE, HOME + 0.8), RATE)
    assert_allclose(run.reference[0], HOME + 0.8, atol=1e-12)
    assert np.abs(np.diff(run.reference, axis=0)).max() < 0.01


def test_an_autostart_that_cannot_get_there_holds_and_says_why(exact_arm, close_loop):
    controller = controller_from_parameters({'experiment': 'joint_step', 'autostart': True}, RATE)
    shooting_out = exact_arm(controller.arm, RATE, [*HOME[:5], 6.2], [0, 0, 0, 0, 0, 3.0])
    close_loop(controller, shooting_out, 1)
    assert 'autostart: wrist_3_joint would go to' in controller.status()['last_refusal']


def test_without_an_experiment_none_is_started(holding):
    controller, _ = holding(HOME)
    with pytest.raises(ValueError, match='no experiment is set'):
        controller.start_experiment()


def test_a_moving_arm_is_taken_over_at_its_speed(exact_arm, close_loop):
    controller = controller_from_parameters({}, RATE)
    speed = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.6])
    run = close_loop(controller, exact_arm(controller.arm, RATE, HOME, speed), 2 * RATE)
    assert_allclose(run.reference_qd[0], speed)
    assert_allclose(run.reference[0], HOME)
    assert run.status[-1] == 'holding'
    assert np.abs(run.error).max() < 0.01


@pytest.mark.parametrize('wish', WISHES)
def test_before_the_first_state_everything_is_refused(wish):
    controller = controller_from_parameters({}, RATE)
    controller.experiment = LAW.experiment
    with pytest.raises(ValueError, match='no state has come yet'):
        steer(controller, wish, np.random.default_rng(1))
    assert controller.status()['state'] == 'waiting for states'
