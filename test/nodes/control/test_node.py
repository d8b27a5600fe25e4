"""The controller on its topics and services, under the simulator."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ur5_ros.config.parameters import HOME
from ur5_ros.signals import JOINT_NAMES

NEAR = [HOME[0] + 0.1, HOME[1] - 0.1, HOME[2] + 0.1, HOME[3], HOME[4], HOME[5] + 0.2]


@pytest.fixture
def arm(ros):
    """Both nodes in lockstep, an observer, and what it hears of states and references."""
    ros.watcher = ros.observer()
    ros.control = ros.start('control', max_velocity=3.0, max_acceleration=20.0, max_jerk=500.0)
    ros.sim = ros.start('sim')
    ros.states = ros.watcher.subscribe(JointState, '/joint_states')
    ros.references = ros.watcher.subscribe(JointTrajectory, '/ur5_control/reference')
    wait_until(lambda: len(ros.references) > 10, 'a running loop')
    return ros


def stands_at(arm, q, tolerance=2e-3):
    """Wait until the arm stands at a configuration."""
    wait_until(lambda: np.abs(np.array(arm.states[-1].position) - q).max() < tolerance
               and np.abs(arm.states[-1].velocity).max() < tolerance, f'the arm at {q}')


def diagnosed(arm, text):
    """Wait until the diagnostics of the controller hold a text."""
    reported = arm.watcher.subscribe(DiagnosticArray, '/diagnostics')
    wait_until(lambda: any(text in pair.value or text in pair.key for message in reported
                           for pair in message.status[0].values), f'{text!r} in the diagnostics')


def test_a_joint_target_is_reached(arm):
    publisher = arm.watcher.publisher(JointState, '/ur5_control/target_joints')
    publisher.publish(JointState(name=list(JOINT_NAMES[::-1]), position=NEAR[::-1]))
    stands_at(arm, NEAR)
    wait_until(lambda: np.allclose(arm.references[-1].points[0].positions, NEAR),
               'the reference at the target')


def test_a_pose_target_is_reached_and_its_branch_reported(arm):
    poses = arm.watcher.subscribe(PoseStamped, '/ur5_control/tool_pose')
    wait_until(lambda: poses, 'the tool pose')
    expected = poses[-1]
    expected.pose.position.z += 0.05
    expected.header.frame_id = 'base'
    arm.watcher.publisher(PoseStamped, '/ur5_control/target_pose').publish(expected)

    def error():
        here, there = poses[-1].pose.position, expected.pose.position
        return max(abs(getattr(here, axis) - getattr(there, axis)) for axis in 'xyz')
    wait_until(lambda: error() < 1e-3, 'the tool at the pose')
    diagnosed(arm, 'branch')


def test_a_trajectory_is_followed(arm):
    message = JointTrajectory(joint_names=list(JOINT_NAMES))
    for seconds, share in ((1, 0.5), (2, 1.0)):
        point = JointTrajectoryPoint(
            positions=[a + share * (b - a) for a, b in zip(HOME, NEAR, strict=True)],
            velocities=[(b - a) * (1.0 - share) for a, b in zip(HOME, NEAR, strict=True)])
        point.time_from_start.sec = seconds
        message.points.append(point)
    arm.watcher.publisher(JointTrajectory, '/ur5_control/joint_trajectory').publish(message)
    stands_at(arm, NEAR)


def test_a_path_is_followed(arm):
    poses = arm.watcher.subscribe(PoseStamped, '/ur5_control/tool_pose')
    wait_until(lambda: poses, 'the tool pose')
    here = poses[-1].pose
    path = Path()
    path.header.frame_id = 'base'
    for lift in (0.0, 0.02, 0.04):
        pose = PoseStamped()
        pose.pose.orientation = here.orientation
        pose.pose.position.x, pose.pose.position.y = here.position.x, here.position.y
        pose.pose.position.z = here.position.z + lift
        path.poses.append(pose)
    arm.watcher.publisher(Path, '/ur5_control/path').publish(path)
    top = path.poses[-1].pose.position.z
    wait_until(lambda: abs(poses[-1].pose.position.z - top) < 1e-3, 'the end of the path')


def wrong_pose(**fields):
    message = PoseStamped()
    message.header.frame_id = fields.get('frame', 'base')
    message.pose.position.x = fields.get('x', 0.4)
    message.pose.orientation.w = fields.get('w', 1.0)
    return message


WRONG = [
    ('target_joints', JointState(name=list(JOINT_NAMES), position=[float('nan')] * 6), 'finite'),
    ('target_joints', JointState(name=list(JOINT_NAMES), position=[0.0] * 5), '5'),
    ('target_joints', JointState(name=['a'] * 6, position=[0.0] * 6), 'unknown'),
    ('target_joints', JointState(name=list(JOINT_NAMES), position=[50.0] * 6), 'rad'),
    ('target_pose', wrong_pose(w=0.5), 'norm'),
    ('target_pose', wrong_pose(x=9.0), 'reach'),
    ('target_pose', wrong_pose(frame='moon'), 'moon'),
    ('joint_trajectory', JointTrajectory(joint_names=list(JOINT_NAMES)), 'point'),
    ('path', Path(), ''),
]


def test_wrong_targets_are_refused_and_the_arm_holds(arm):
    reported = arm.watcher.subscribe(DiagnosticArray, '/diagnostics', publishers=2)
    wait_until(lambda: len(reported) > 2, 'diagnostics')
    for topic, message, printed in WRONG:
        key = f'/ur5_control/{topic}: refused'

        def count(key=key):
            found = [int(pair.value) for message in reported[-2:]
                     for pair in message.status[0].values if pair.key == key]
            return found[-1] if found else 0

        before = count()
        arm.watcher.publisher(type(message), f'/ur5_control/{topic}').publish(message)
        wait_until(lambda before=before: count() > before, f'{topic} refused')
        assert any(printed in pair.value for message in reported[-2:]
                   for pair in message.status[0].values if pair.key == 'last_refusal'), printed
    running = len(arm.states)
    wait_until(lambda: len(arm.states) > running + 100, 'a hundred states more')
    assert np.abs(np.array(arm.states[-1].position) - HOME).max() < 1e-4


def test_services_and_live_parameters_are_served(arm):
    set_parameters = arm.watcher.set_parameters
    assert set_parameters('ur5_control', kp=25, kd=[10.0]).successful
    for wrong in ({'kp': -1.0}, {'kp': [1.0, 2.0]}, {'kd': float('nan')}, {'arm': 'ur10'}):
        assert not set_parameters('ur5_control', **wrong).successful
    refused = arm.watcher.call(Trigger, '/ur5_control/start_experiment')
    assert not refused.success
    assert 'experiment' in refused.message
    publisher = arm.watcher.publisher(JointState, '/ur5_control/target_joints')
    publisher.publish(JointState(name=list(JOINT_NAMES), position=NEAR))
    assert arm.watcher.call(Trigger, '/ur5_control/hold').success
    wait_until(lambda: np.abs(arm.states[-1].velocity).max() < 1e-4, 'the arm at rest')


def test_errors_parts_and_poses_come_at_the_monitor_rate(arm):
    errors = arm.watcher.subscribe(JointState, '/ur5_control/error')
    parts = arm.watcher.subscribe(JointState, '/ur5_control/torque_parts')
    expected = arm.watcher.subscribe(PoseStamped, '/ur5_control/reference_pose')
    wait_until(lambda: len(errors) > 5 and len(parts) > 5 and len(expected) > 5, 'five of each')
    stamps = [message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
              for message in errors]
    assert set(np.diff(stamps[:5])) == {20_000_000}
    efforts = dict(zip(parts[-1].name, parts[-1].effort, strict=True))
    for joint in JOINT_NAMES:
        assert efforts[f'total/{joint}'] == pytest.approx(sum(
            efforts[f'{part}/{joint}'] for part in ('inertial', 'feedback', 'coriolis',
                                                    'gravity')))
