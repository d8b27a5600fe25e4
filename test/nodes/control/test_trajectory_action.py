from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.tolerances import ResultCode
from ur5_ros.nodes.control.trajectory_action import goal_arguments
from ur5_ros.signals import JOINT_NAMES, ArmState


def test_a_goal_reaches_the_controller_with_everything_in_it():
    home = np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
    trajectory = JointTrajectory(joint_names=JOINT_NAMES[::-1])
    trajectory.points = [JointTrajectoryPoint(
        positions=(home + 0.1)[::-1].tolist(), velocities=[0.0] * 6,
        time_from_start=Duration(sec=0, nanosec=500_000_000))]
    tolerance = SimpleNamespace(name='elbow_joint', position=-1.0, velocity=0.0, acceleration=0.0)
    goal = SimpleNamespace(
        trajectory=trajectory, path_tolerance=[tolerance], goal_tolerance=[],
        goal_time_tolerance=Duration(sec=-1))
    arguments = goal_arguments(goal)
    assert arguments['stamp'] == 0
    assert arguments['goal_time'] == -1.0
    controller = controller_from_parameters({}, 500)
    q, zero = home, np.zeros(6)
    controller.update(ArmState(2_000_000, q, zero, zero))
    number = controller.follow_joint_trajectory(**arguments)
    for k in range(2, 300):
        q = controller.update(ArmState(k * 2_000_000, q, zero, zero)).reference.q
    assert controller.goal_verdict(number).code == ResultCode.SUCCESSFUL
    assert q == pytest.approx(home + 0.1)
    assert controller.last[1].reference.q == pytest.approx(home + 0.1)
