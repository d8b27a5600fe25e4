"""A thousand poses in sequence: each reached, or refused before the arm moves."""

import numpy as np
from numpy.testing import assert_allclose

from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.signals import JOINT_NAMES

RATE = 125  # the rate of a UR5's controller
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])


def angle_between(one, two):
    return 2.0 * np.arcsin(min(1.0, np.linalg.norm(one[:3, :3] - two[:3, :3]) / np.sqrt(8.0)))


def test_a_thousand_random_poses_are_reached_or_refused(close_loop, exact_arm):
    controller = controller_from_parameters(
        {'kp': [400.0], 'kd': [40.0], 'max_velocity': [2.5], 'max_acceleration': [8.0],
         'max_jerk': [80.0]}, RATE)
    arm, limits = controller.arm, controller.arm.limits
    plant = exact_arm(arm, RATE, HOME)
    close_loop(controller, plant, 1)
    random = np.random.default_rng(2016)
    refusals, reached = [], 0
    for _ in range(1000):
        pose = forward_kinematics(random.uniform(-np.pi, np.pi, 6), arm)
        before = controller.update(plant.state).reference
        try:
            controller.target_pose(pose)
        except InputError as refusal:
            refusals.append(str(refusal))
            assert controller.update(plant.state).reference is before
            continue
        status, rows = 'moving', []
        while status == 'moving':
            run = close_loop(controller, plant, 25)
            status = run.status[-1]
            rows.append(run)
        rows.append(close_loop(controller, plant, 100))
        assert rows[-1].status[-1] == 'holding'
        q, reference = (np.concatenate([getattr(run, name) for run in rows])
                        for name in ('q', 'reference'))
        assert np.all((q >= limits.lower) & (q <= limits.upper))
        assert np.abs(np.diff(reference, axis=0)).max() <= 2.5 / RATE + 1e-9  # no jump
        assert np.abs(q - reference).max() < 0.05  # no fall
        there = forward_kinematics(plant.q, arm)
        assert np.linalg.norm(there[:3, 3] - pose[:3, 3]) < 1e-4
        assert angle_between(there, pose) < 1e-4
        reached += 1
    assert reached + len(refusals) == 1000
    assert reached > 700
    assert all('max_joint_jump' in words and any(name in words for name in JOINT_NAMES)
               for words in refusals)


def test_a_target_reached_is_the_target_kept(holding, close_loop):
    controller, plant = holding(HOME)
    pose = forward_kinematics(HOME + 0.3, controller.arm)
    controller.target_pose(pose)
    run = close_loop(controller, plant, 5000)
    assert_allclose(forward_kinematics(run.q[-1], controller.arm), pose, atol=1e-5)
