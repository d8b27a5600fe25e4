"""
The action ``~/follow_joint_trajectory`` for MoveIt and its like, where control_msgs is installed.

It behaves as the joint_trajectory_controller of ros2_controllers 4.42 does: invalid goals are
rejected, a goal executes until its verdict, and a new goal replaces the one before. The judging is
in :mod:`ur5_ros.control.tolerances`.
"""

from typing import TYPE_CHECKING, Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from ur5_ros.control.controller import Controller
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.tolerances import GoalError, JointTolerance, ResultCode, Verdict
from ur5_ros.errors import InputError
from ur5_ros.nodes.ros.process import fault
from ur5_ros.signals import JOINT_NAMES

if TYPE_CHECKING:
    from ur5_ros.nodes.control.node import ControlNode

#: How often goals are looked at [Hz], as the joint_trajectory_controller's action_monitor_rate.
MONITOR_RATE = 20.0


def create_trajectory_action(node: Node, control: 'ControlNode') -> 'TrajectoryAction | None':
    """
    Offer ``~/follow_joint_trajectory`` if control_msgs can be imported; log a line if not.

    Returned: None without control_msgs.
    """
    try:
        from control_msgs.action import FollowJointTrajectory
    except ImportError:
        node.get_logger().info('control_msgs is not installed: there is no action '
                               '~/follow_joint_trajectory (ros-jazzy-control-msgs)')
        return None
    return TrajectoryAction(node, control, FollowJointTrajectory)


def goal_arguments(goal: Any) -> dict[str, Any]:
    """Return a FollowJointTrajectory goal as ``Controller.follow_joint_trajectory`` takes it."""
    if (goal.multi_dof_trajectory.joint_names or goal.component_path_tolerance
            or goal.component_goal_tolerance):
        raise InputError('the goal has joints of several degrees of freedom; leave '
                         'multi_dof_trajectory and component_*_tolerance empty')
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
    """Goals handed to the controller, results handed back; nothing here waits."""

    def __init__(self, node: Node, control: 'ControlNode', action_type: Any) -> None:
        from rclpy.action import ActionServer, CancelResponse, GoalResponse  # used here alone

        class Server(ActionServer):
            """An action server whose goals execute until :meth:`TrajectoryAction._finish`."""

            def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
                if execute_callback is not None:
                    super().notify_execute(goal_handle, execute_callback)

        self._control, self._type = control, action_type
        self._responses = {True: GoalResponse.ACCEPT, False: GoalResponse.REJECT}
        self._logger = node.get_logger()
        self._begun: tuple[Controller, int] | None = None
        self._open: list[tuple[Any, Controller, int]] = []
        self._ending = False
        self._server = Server(
            node, action_type, '~/follow_joint_trajectory', lambda goal: action_type.Result(),
            goal_callback=self._begin, handle_accepted_callback=self._accept,
            cancel_callback=lambda goal: CancelResponse.ACCEPT)
        self._timer = node.create_timer(1.0 / MONITOR_RATE, self._update,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def close(self) -> None:
        """Abort what is open; the results are on their way when :attr:`idle` is true."""
        self._ending = True

    @property
    def idle(self) -> bool:
        """Whether no goal waits for its result."""
        return not self._open

    def _begin(self, goal: Any) -> Any:
        """Begin to follow a goal, which is then accepted, or reject it with a line in the log."""
        def begin() -> tuple[Controller, int]:
            controller = self._control.cycle.controller
            return controller, controller.follow_joint_trajectory(**arguments)

        try:
            if self._ending:
                raise InputError('the node is ending; start it again')
            arguments = goal_arguments(goal)
            self._begun = self._control.requests.call(begin)
        except InputError as error:
            code = error.code if isinstance(error, GoalError) else ResultCode.INVALID_GOAL
            self._logger.warning(f'goal rejected: {code.name} ({code:d}): {error}')
            self._begun = None
        except Exception as error:  # a client waits for an answer, whatever happened
            fault(self._logger, error)
            self._begun = None
        return self._responses[self._begun is not None]

    def _accept(self, goal: Any) -> None:
        """Let an accepted goal execute until its verdict."""
        assert self._begun is not None, 'accepted goals have begun'
        goal.execute()
        self._open.append((goal, *self._begun))

    def _update(self) -> None:
        """Hand out what has ended, stop what was cancelled, report how far the others are."""
        still_open = []
        for goal, controller, number in self._open:
            verdict = self._verdict(goal, controller, number)
            if verdict is None:
                goal.publish_feedback(self._feedback())
                still_open.append((goal, controller, number))
            else:
                self._finish(goal, verdict)
        self._open = still_open

    def _verdict(self, goal: Any, controller: Controller, number: int) -> Verdict | None:
        """Return how a goal ended; None while it is on."""
        verdict = controller.goal_verdict(number)
        if verdict is not None:
            return verdict
        if self._ending:
            return Verdict(ResultCode.INVALID_GOAL, 'the node is ending')
        if controller is not self._control.cycle.controller:
            return Verdict(ResultCode.INVALID_GOAL, 'the robot started again')
        if goal.is_cancel_requested:
            self._control.requests.call(controller.hold)
            return Verdict(ResultCode.SUCCESSFUL, 'cancelled; the arm comes to rest')
        return None

    def _finish(self, goal: Any, verdict: Verdict) -> None:
        """Set the final state of a goal and hand out its result."""
        def end(goal: Any) -> Any:
            code = verdict.code
            if goal.is_cancel_requested:
                goal.canceled()
                code = ResultCode.SUCCESSFUL
            elif code == ResultCode.SUCCESSFUL:
                goal.succeed()
            else:
                goal.abort()
                self._logger.warning(f'goal aborted: {code.name} ({code:d}): {verdict.message}')
            return self._type.Result(error_code=int(code), error_string=verdict.message)

        self._server.notify_execute(goal, end)

    def _feedback(self) -> Any:
        controller = self._control.cycle.controller
        state, answer = self._control.requests.call(lambda: controller.last)
        prefix = controller.parameters.tf_prefix
        feedback = self._type.Feedback(joint_names=[prefix + name for name in JOINT_NAMES])
        feedback.header.stamp.sec, feedback.header.stamp.nanosec = divmod(answer.stamp, 10**9)
        desired = answer.reference
        for point, q, qd in ((feedback.desired, desired.q, desired.qd),
                             (feedback.actual, state.q, state.qd),
                             (feedback.error, desired.q - state.q, desired.qd - state.qd)):
            point.positions, point.velocities = q.tolist(), qd.tolist()
        return feedback


def _nanoseconds(time: Any) -> int:
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def _tolerance(message: Any) -> JointTolerance:
    return JointTolerance(message.name, message.position, message.velocity, message.acceleration)
