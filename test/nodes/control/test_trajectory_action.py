"""The action as MoveIt and other clients of the joint_trajectory_controller expect it."""

from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from rclpy.action import ActionClient
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory

from ur5_ros.config.parameters import HOME
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.tolerances import ResultCode
from ur5_ros.nodes.control.trajectory_action import TrajectoryAction, goal_arguments
from ur5_ros.signals import JOINT_NAMES, ArmState

#: action_msgs/GoalStatus.
ACCEPTED, EXECUTING, SUCCEEDED, CANCELED, ABORTED = 1, 2, 4, 5, 6


def trajectory(goal, seconds=0.5, names=JOINT_NAMES, stamp=0.0, **more):
    """Return a trajectory of one point."""
    whole, part = divmod(round(seconds * 1e9), 10**9)
    result = JointTrajectory(joint_names=names)
    result.header.stamp = Time(sec=int(stamp), nanosec=round(stamp % 1.0 * 1e9))
    result.points = [JointTrajectoryPoint(
        positions=list(goal), time_from_start=Duration(sec=whole, nanosec=part),
        **{'velocities': [0.0] * len(goal)} | more)]
    return result


class Client:
    """A client of the action, and a simulator and a controller to serve it."""

    def __init__(self, ros, interfaces, **control):
        from action_msgs.msg import GoalStatusArray
        from control_msgs.action import FollowJointTrajectory
        from control_msgs.msg import JointTolerance
        self.action, self.tolerance = FollowJointTrajectory, JointTolerance
        self.sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000,
                             command_timeout=1.0, bag='none')
        self.control = ros.start('control', environment=interfaces, bag='none', **control)
        self.observer = ros.observer()
        self.statuses, self.feedback = [], []
        self.states = self.observer.subscribe(JointState, '/joint_states')
        self.client = ActionClient(self.observer.node, FollowJointTrajectory,
                                   '/ur5_control/follow_joint_trajectory')
        wait_until(self.client.server_is_ready, 'the action')
        self.observer.subscribe(
            GoalStatusArray, '/ur5_control/follow_joint_trajectory/_action/status', kept=True,
            react=lambda received: self.statuses.append(
                [each.status for each in received.status_list][-1:]))
        commands = self.observer.subscribe(JointState, '/joint_command')
        wait_until(lambda: len(commands) > 5, 'commands')

    def send(self, goal=None, **fields):
        """Send a goal; return its handle."""
        message = self.action.Goal()
        message.trajectory = trajectory(HOME) if goal is None else goal
        for name, value in fields.items():
            setattr(message, name, value)
        future = self.observer.in_its_thread(lambda: self.client.send_goal_async(
            message, feedback_callback=lambda each: self.feedback.append(each.feedback)))
        wait_until(future.done, 'an answer to the goal')
        return future.result()

    def result(self, handle):
        """Wait for the result of a goal; return its status, code and text."""
        future = self.observer.in_its_thread(handle.get_result_async)
        wait_until(future.done, 'the result of the goal')
        found = future.result()
        return found.status, found.result.error_code, found.result.error_string

    def close(self):
        assert self.control.stop() == 0, self.control.text
        assert self.sim.stop() == 0, self.sim.text


@pytest.fixture(scope='module')
def served(tmp_path_factory, interfaces):
    from ros_processes import ros_domain
    with ros_domain(tmp_path_factory.mktemp('action')) as ros:
        client = Client(ros, interfaces)
        yield client
        client.close()


def moved(by):
    return (np.array(HOME) + by).tolist()


def test_a_goal_executes_until_it_succeeds(served):
    served.feedback.clear(), served.statuses.clear()
    handle = served.send(trajectory(moved([0.2, 0, 0, 0, 0, 0])[::-1], 1.0, JOINT_NAMES[::-1]))
    assert handle.accepted
    wait_until(lambda: served.feedback, 'feedback')
    # the status is another topic: it may come a moment after the feedback
    wait_until(lambda: served.statuses[-1:] == [[EXECUTING]], 'the status')
    assert served.result(handle)[:2] == (SUCCEEDED, ResultCode.SUCCESSFUL)
    one = served.feedback[0]
    assert one.joint_names == list(JOINT_NAMES) and one.header.stamp.sec >= 0
    assert np.subtract(one.desired.positions, one.actual.positions) == pytest.approx(
        one.error.positions)
    assert served.states[-1].position[0] == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize(('goal', 'fields', 'code'), [
    (JointTrajectory(joint_names=JOINT_NAMES), {}, 'INVALID_GOAL (-1)'),
    (trajectory([0.0] * 5, names=JOINT_NAMES[:5]), {}, 'INVALID_JOINTS (-2)'),
    (trajectory(HOME, names=[*JOINT_NAMES[:5], 'finger']), {}, 'INVALID_JOINTS (-2)'),
    (trajectory(HOME, names=[*JOINT_NAMES[:5], JOINT_NAMES[0]]), {}, 'INVALID_JOINTS (-2)'),
    (trajectory(HOME, 1e-9, stamp=1e-3), {}, 'OLD_HEADER_TIMESTAMP (-3)'),
    (trajectory(HOME, velocities=[1.0] * 6), {}, 'INVALID_GOAL (-1)'),
    (trajectory([float('nan')] * 6), {}, 'INVALID_GOAL (-1)'),
    (trajectory([99.0] * 6), {}, 'INVALID_GOAL (-1)'),
    (trajectory(HOME, effort=[1.0] * 6), {}, 'INVALID_GOAL (-1)'),
    (trajectory(HOME, 0.0), {}, 'INVALID_GOAL (-1)'),
    (None, {'goal_time_tolerance': Duration(sec=-2)}, 'INVALID_GOAL (-1)'),
    (None, {'multi_dof_trajectory': MultiDOFJointTrajectory(joint_names=['base'])},
     'INVALID_GOAL (-1)'),
])
def test_an_invalid_goal_is_rejected_with_a_line_and_moves_nothing(served, goal, fields, code):
    before = len(served.control.text)
    assert not served.send(goal, **fields).accepted
    wait_until(lambda: code in served.control.text[before:], f'{code} in the log')
    assert served.control.text[before:].count('goal rejected') == 1


def test_an_unknown_joint_in_a_tolerance_is_rejected(served):
    assert not served.send(path_tolerance=[served.tolerance(name='finger')]).accepted


def test_a_cancelled_goal_is_canceled_with_code_0_and_the_arm_rests(served):
    handle = served.send(trajectory(moved([-0.5, 0, 0, 0, 0, 0]), 5.0))
    wait_until(lambda: abs(served.states[-1].velocity[0]) > 0.05, 'motion')
    future = served.observer.in_its_thread(handle.cancel_goal_async)
    assert served.result(handle)[:2] == (CANCELED, ResultCode.SUCCESSFUL)
    wait_until(future.done, 'an answer to the cancel request')
    wait_until(lambda: max(map(abs, served.states[-1].velocity)) < 1e-3, 'rest')
    assert served.states[-1].position[0] > -0.45


def test_a_goal_that_leaves_its_path_is_aborted_with_code_4(served):
    narrow = [served.tolerance(name=JOINT_NAMES[0], position=1e-9)]
    handle = served.send(trajectory(moved([0.5, 0, 0, 0, 0, 0]), 2.0), path_tolerance=narrow)
    status, code, text = served.result(handle)
    assert (status, code) == (ABORTED, ResultCode.PATH_TOLERANCE_VIOLATED)
    assert JOINT_NAMES[0] in text and '1e-09' in text


def test_a_goal_that_is_not_reached_is_aborted_with_code_5(served):
    narrow = [served.tolerance(name=name, velocity=1e-12) for name in JOINT_NAMES]
    handle = served.send(trajectory(moved([0.1, 0, 0, 0, 0, 0]), 0.5), goal_tolerance=narrow,
                         goal_time_tolerance=Duration(nanosec=20_000_000))
    assert served.result(handle)[:2] == (ABORTED, ResultCode.GOAL_TOLERANCE_VIOLATED)
    assert 'goal aborted: GOAL_TOLERANCE_VIOLATED (-5)' in served.control.text


def test_a_new_goal_replaces_the_one_before(served):
    first = served.send(trajectory(moved([0.3, 0, 0, 0, 0, 0]), 5.0))
    second = served.send(trajectory(moved([-0.1, 0, 0, 0, 0, 0]), 1.0))
    status, code, text = served.result(first)
    assert (status, code) == (ABORTED, ResultCode.INVALID_GOAL) and 'preempted' in text
    assert served.result(second)[0] == SUCCEEDED


def test_a_service_that_takes_the_arm_ends_the_goal(served):
    handle = served.send(trajectory(moved([0.3, 0, 0, 0, 0, 0]), 5.0))
    assert served.observer.call(Trigger, '/ur5_control/hold').success
    status, code, text = served.result(handle)
    assert (status, code) == (ABORTED, ResultCode.INVALID_GOAL) and 'hold' in text


@pytest.mark.parametrize('use_sim_time', [False, True])
def test_states_that_stop_end_the_goal_and_so_does_the_end_of_the_node(ros, interfaces,
                                                                       use_sim_time):
    """Whatever clock the node was given: a simulator that is gone stops the simulated one."""
    client = Client(ros, interfaces, use_sim_time=use_sim_time)
    handle = client.send(trajectory(moved([0.3, 0, 0, 0, 0, 0]), 30.0))
    client.sim.kill()
    status, code, text = client.result(handle)
    assert (status, code) == (ABORTED, ResultCode.INVALID_GOAL) and 'states' in text
    client.sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000, bag='none')
    received = len(client.states)
    wait_until(lambda: len(client.states) > received + 50, 'states of the new simulator')
    handle = client.send(trajectory(moved([0.3, 0, 0, 0, 0, 0]), 30.0))
    future = client.observer.in_its_thread(handle.get_result_async)
    assert client.control.stop() == 0
    wait_until(future.done, 'a result of the node that ended', 5.0)
    assert future.result().status == ABORTED
    assert 'ending' in future.result().result.error_string
    assert client.sim.stop() == 0


def test_a_simulator_that_starts_again_ends_the_goal(ros, interfaces):
    client = Client(ros, interfaces, state_timeout=30.0)
    handle = client.send(trajectory(moved([0.3, 0, 0, 0, 0, 0]), 60.0))
    client.sim.kill()
    client.sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000, bag='none')
    status, code, text = client.result(handle)
    assert (status, code) == (ABORTED, ResultCode.INVALID_GOAL)
    assert text == 'the robot started again'
    client.close()


def test_a_goal_for_a_node_that_fails_or_ends_is_answered(ros, interfaces, capfd):
    """The end of a node is too short for a client to meet, and no defect is known."""
    from control_msgs.action import FollowJointTrajectory

    def fail(work):
        raise RuntimeError('a defect')

    server, watcher = ros.observer('server'), ros.observer()
    control = SimpleNamespace(requests=SimpleNamespace(call=fail))
    action = TrajectoryAction(server.node, control, FollowJointTrajectory)
    client = ActionClient(watcher.node, FollowJointTrajectory, 'server/follow_joint_trajectory')
    wait_until(client.server_is_ready, 'the action')
    goal = FollowJointTrajectory.Goal(trajectory=trajectory(HOME))
    for ending, line in ((False, 'fault: RuntimeError: a defect'),
                         (True, 'goal rejected: INVALID_GOAL (-1): the node is ending')):
        if ending:
            action.close()
        future = watcher.in_its_thread(lambda: client.send_goal_async(goal))
        wait_until(future.done, 'an answer to the goal')
        assert not future.result().accepted and action.idle
        assert line in capfd.readouterr().err


def test_without_control_msgs_a_line_names_what_to_install(ros):
    control = ros.start('control', bag='none')
    control.wait_for_line('waiting for states')
    control.lacks('control_msgs')
    assert control.stop() == 0


def test_a_goal_reaches_the_controller_with_everything_in_it():
    home = np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
    tolerance = SimpleNamespace(name='elbow_joint', position=-1.0, velocity=0.0, acceleration=0.0)
    goal = SimpleNamespace(
        trajectory=trajectory((home + 0.1)[::-1].tolist(), names=JOINT_NAMES[::-1]),
        multi_dof_trajectory=MultiDOFJointTrajectory(), component_path_tolerance=[],
        component_goal_tolerance=[], path_tolerance=[tolerance], goal_tolerance=[],
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
