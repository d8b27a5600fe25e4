"""
The action ``~/follow_joint_trajectory`` for MoveIt and its like, where control_msgs is installed.

control_msgs is not on PyPI: what is here beyond :func:`goal_arguments` runs in no test of ours.
All judging is in :mod:`ur5_ros.control.tolerances` and tested there.
"""

from typing import Any

from rclpy.node import Node

from ur5_ros.control.controller import Controller
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.tolerances import JointTolerance, ResultCode, Verdict
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

#: How often goals are looked at [Hz], as the joint_trajectory_controller's action_monitor_rate.
MONITOR_RATE = 20.0


def offer_trajectory_action(node: Node, control: Any) -> 'TrajectoryAction | None':
    """
    Offer ``~/follow_joint_trajectory`` if control_msgs can be imported.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    control : Steering
        Whose controller follows.

    Returns
    -------
    TrajectoryAction or None
        None without control_msgs.

    """
    try:
        from control_msgs.action import FollowJointTrajectory
    except ImportError:
        return None
    return TrajectoryAction(node, control, FollowJointTrajectory)


def goal_arguments(goal: Any) -> dict[str, Any]:
    """
    Return a FollowJointTrajectory goal as ``Controller.follow_joint_trajectory`` takes it.

    Parameters
    ----------
    goal : control_msgs.action.FollowJointTrajectory.Goal
        The goal.

    Returns
    -------
    dict
        Keyword arguments.

    """
    trajectory = goal.trajectory
    return {
        'names': list(trajectory.joint_names),
        'points': [
            TrajectoryPoint(_nanoseconds(point.time_from_start), list(point.positions),
                            list(point.velocities), list(point.accelerations), list(point.effort))
            for point in trajectory.points],
        'stamp': _nanoseconds(trajectory.header.stamp),
        'path_tolerance': [_tolerance(each) for each in goal.path_tolerance],
        'goal_tolerance': [_tolerance(each) for each in goal.goal_tolerance],
        'goal_time': _nanoseconds(goal.goal_time_tolerance) / 1e9,
    }


class TrajectoryAction:
    """
    Goals handed to the controller, results handed back; nothing here waits.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    control : Steering
        Whose controller follows.
    action_type : type
        control_msgs.action.FollowJointTrajectory.

    """

    def __init__(self, node: Node, control: Any, action_type: Any) -> None:
        from rclpy.action import ActionServer, CancelResponse  # needed here alone
        self._control, self._type = control, action_type
        self._open: list[tuple[Any, Controller, int]] = []
        self._server = ActionServer(
            node, action_type, '~/follow_joint_trajectory', self._no_verdict,
            handle_accepted_callback=self._accept,
            cancel_callback=lambda goal: CancelResponse.ACCEPT)
        self._timer = node.create_timer(1.0 / MONITOR_RATE, self._look)

    def _accept(self, goal: Any) -> None:
        """Begin to follow; a goal that the controller refuses is aborted at once."""
        try:
            arguments = goal_arguments(goal.request)
            number = self._ask(lambda controller: controller.follow_joint_trajectory(**arguments))
        except InputError as refusal:
            self._finish(goal, Verdict(ResultCode.INVALID_GOAL, str(refusal)))
            return
        self._open.append((goal, self._control.cycle.controller, number))

    def _look(self) -> None:
        """Hand out what has ended, stop what was cancelled, publish the progress of the others."""
        still_open = []
        for goal, begun_by, number in self._open:
            verdict = begun_by.goal_verdict(number)
            if verdict is None and begun_by is not self._control.cycle.controller:
                verdict = Verdict(ResultCode.INVALID_GOAL, 'the robot started again')
            if verdict is None and goal.is_cancel_requested:
                self._ask(lambda controller: controller.hold())
                verdict = begun_by.goal_verdict(number)
            if verdict is None:
                goal.publish_feedback(self._feedback())
                still_open.append((goal, begun_by, number))
            else:
                self._finish(goal, verdict)
        self._open = still_open

    def _finish(self, goal: Any, verdict: Verdict) -> None:
        def end(goal: Any) -> Any:
            if goal.is_cancel_requested:
                goal.canceled()
            elif verdict.code == ResultCode.SUCCESSFUL:
                goal.succeed()
            else:
                goal.abort()
            return self._type.Result(error_code=int(verdict.code), error_string=verdict.message)

        goal.execute(end)

    def _feedback(self) -> Any:
        controller = self._control.cycle.controller
        state, answer = self._ask(lambda controller: controller.last)
        prefix = controller.parameters.tf_prefix
        feedback = self._type.Feedback(joint_names=[prefix + name for name in JOINT_NAMES])
        feedback.header.stamp.sec, feedback.header.stamp.nanosec = divmod(answer.stamp, 10**9)
        desired = answer.reference
        for point, q, qd in ((feedback.desired, desired.q, desired.qd),
                             (feedback.actual, state.q, state.qd),
                             (feedback.error, desired.q - state.q, desired.qd - state.qd)):
            point.positions, point.velocities = q.tolist(), qd.tolist()
        return feedback

    def _ask(self, question: Any) -> Any:
        return self._control.requests.call(lambda: question(self._control.cycle.controller))

    def _no_verdict(self, goal: Any) -> Any:
        goal.abort()
        return self._type.Result(error_code=int(ResultCode.INVALID_GOAL),
                                 error_string='the node is ending')


def _nanoseconds(time: Any) -> int:
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def _tolerance(message: Any) -> JointTolerance:
    return JointTolerance(message.name, message.position, message.velocity, message.acceleration)
