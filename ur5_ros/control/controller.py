"""The controller under the node: states in, torques out, trajectories on request."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control import planning
from ur5_ros.control.computed_torque import TorqueLaw
from ur5_ros.control.experiment import ExperimentTrajectory, experiment_trajectory
from ur5_ros.control.force_guard import ForceGuard
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.kernel import STATE
from ur5_ros.control.laws.checked import CheckedLaw
from ur5_ros.control.motion_requests import NO_STATE, MotionRequests
from ur5_ros.control.output import ControlOutput, describe, status_of
from ur5_ros.control.settings import changed, settings_from
from ur5_ros.control.state_validation import StateStatus, StateValidator, joint_beyond
from ur5_ros.control.tolerances import (
    JointTolerance,
    ResultCode,
    Verdict,
    resolve_tolerances,
)
from ur5_ros.control.torque_command import TorqueCommand
from ur5_ros.errors import InputError
from ur5_ros.model.inverse_kinematics import inverse_kinematics_batch
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference


def controller_from_parameters(
    parameters: Mapping[str, Any] | ControlParameters, control_rate: int | None = None,
) -> 'Controller':
    """
    Return the controller that the parameters of control_node describe.

    ``parameters``: values of ``CONTROL_PARAMETERS``; what is missing takes its default;
    ``control_rate``: control periods a second [Hz], where known.
    """
    complete_set = ControlParameters.of(parameters)
    return Controller(load_arm(complete_set.arm), complete_set, control_rate)


class Controller:
    """
    Control law and trajectories, without ROS: equal inputs give equal bits.

    Parameters
    ----------
    arm : ArmParameters
        The controller's arm.
    parameters : mapping, optional
        Values of ``CONTROL_PARAMETERS``; what is missing takes its default; ``arm`` is not read.
    control_rate : int, optional
        Control periods a second [Hz], where known: the grid of tabled trajectories.
    experiment : ExperimentTrajectory, optional
        The experiment of the parameters, where a controller before has made it.

    Raises
    ------
    InputError
        If a parameter, the arm or the experiment is refused.

    Examples
    --------
    >>> from ur5_ros import JOINT_NAMES, Controller, Plant, load_arm
    >>> arm = load_arm('ur5')
    >>> plant, controller = Plant(arm), Controller(arm, {'kp': 100.0, 'kd': 20.0})
    >>> state = plant.state
    >>> torque = controller.update(state).torque
    >>> controller.target_joints(JOINT_NAMES, state.q + 0.1)
    >>> for _ in range(2000):
    ...     state = plant.step(torque.total)
    ...     torque = controller.update(state).torque
    >>> controller.status()['state']
    'holding'
    >>> plant.close()

    """

    def __init__(self, arm: ArmParameters,
                 parameters: Mapping[str, Any] | ControlParameters | None = None,
                 control_rate: int | None = None,
                 experiment: ExperimentTrajectory | None = None):
        self.parameters = ControlParameters.of(parameters)
        self.arm = arm
        self._rate = control_rate
        self._settings = settings_from(self.parameters, self.arm, control_rate)
        self._names = self._settings.joint_names
        self.experiment = experiment
        if self.parameters.experiment and experiment is None:
            self.experiment = experiment_trajectory(
                load_experiment(self.parameters.experiment), self.arm,
                self._settings.control_rate, self._settings.singularity_margin)
        self._guard = ForceGuard(arm)
        self._torque = TorqueCommand(arm, self.parameters, self._settings)
        self._validator = StateValidator()
        self._requests = MotionRequests(self._names)
        self._executor, self._goals = self._requests.executor, self._requests.goals
        self._output: ControlOutput | None = None
        self._waiting = True
        self._beyond = False
        self._counts = {'unbelieved_states': 0, 'limited_periods': 0}
        inverse_kinematics_batch(np.eye(4)[None], self.arm)  # compiled before a target needs it

    def update(self, state: ArmState) -> ControlOutput:
        """
        Return the torque that answers a state.

        Parameters
        ----------
        state : ArmState
            The newest state; the same stamp again gives the same output and changes nothing.

        Returns
        -------
        ControlOutput
            Torque, reference, status.

        Raises
        ------
        InputError
            If the state cannot be answered: it is not finite and there was none before it, too
            many in a row were implausible, or the torque is not finite.

        """
        stamp, last = state.stamp, self._output
        if last is not None and stamp == last.stamp:
            return last
        if self._settings.guard_force > 0.0 and last is not None:
            why = self._guard.exceeded(state, self._executor, self._settings.guard_force)
            if why:
                self._requests.stop('guarded', stamp, self._settings.motion_limits, why)
        code, before = STATE, self._validator.predecessor(stamp)
        if before is not None and not self._goals.active:
            reference, parts, code = self._evaluate(state, before.q, stamp, last)
        if code & STATE:
            state, last = self._check(state)
            reference, parts, code = self._evaluate(state, state.q, stamp, last)
        else:
            self._validator.accept(state, StateStatus.FOLLOWS)
            self._beyond = False
        limited = self._torque.limit(parts, code, stamp, last)
        self._counts['limited_periods'] += bool(limited)
        self._waiting = False
        self._output = ControlOutput(stamp, parts, reference, self._status(), limited)
        return self._output

    def _evaluate(self, state: ArmState, q_before: np.ndarray, stamp: int,
                  last: ControlOutput | None) -> tuple[Reference, np.ndarray, int]:
        """Return the reference, the torque with its parts, and which bounds are exceeded."""
        reference = self._executor.at(stamp, self._settings.motion_limits)
        return reference, *self._torque(state, q_before, reference, stamp, last)

    def _check(self, state: ArmState) -> tuple[ArmState, ControlOutput | None]:
        """Return the state to answer and the output before; None where a new motion starts."""
        last = self._output
        status = self._validator.validate(state, self._settings.max_state_jump)
        stamp = state.stamp
        if status is StateStatus.FOLLOWS:
            self._watch_limits(state)
        elif status is StateStatus.IMPLAUSIBLE:
            self._counts['unbelieved_states'] += 1
            state = self._validator.last or state
        else:
            self._take_over(state, status)
            last = None
        self._waiting = False
        self._requests.judge(state, stamp, self._settings.motion_limits)
        return state, last

    def start_experiment(self) -> None:
        """Move to the start of the experiment and run it; refused if there is none."""
        self._plan('start_experiment', planning.plan_experiment, self.experiment)

    def hold(self) -> None:
        """Bring the reference to rest, jerk-limited, and hold it."""
        self._plan('hold', planning.plan_stop)

    def target_joints(self, names: Sequence[str], positions: Sequence[float]) -> None:
        """Move to joint positions; see :func:`~ur5_ros.control.planning.plan_joints`."""
        self._plan('target_joints', planning.plan_joints, names, positions)

    def target_pose(self, pose: np.ndarray, frame: str = 'base') -> None:
        """Move to a tool pose; see :func:`~ur5_ros.control.planning.plan_pose`."""
        self._plan('target_pose', planning.plan_pose, pose, frame)

    def joint_trajectory(self, names: Sequence[str], points: Sequence[TrajectoryPoint],
                         stamp: int = 0) -> None:
        """Follow a joint trajectory; see :func:`~ur5_ros.control.planning.plan_trajectory`."""
        self._plan('joint_trajectory', planning.plan_trajectory, names, points, stamp, self.stamp)

    def follow_joint_trajectory(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: int = 0,
        path_tolerance: Sequence[JointTolerance] = (),
        goal_tolerance: Sequence[JointTolerance] = (), goal_time: float = 0.0,
    ) -> int:
        """
        Follow a joint trajectory as the action FollowJointTrajectory does: judged on the way.

        Returns
        -------
        int
            Number of the goal, for :meth:`goal_verdict`.

        """
        tolerances = resolve_tolerances(self._settings.tolerances, path_tolerance, goal_tolerance,
                                        goal_time, self._names)
        self.joint_trajectory(names, points, stamp)
        return self._goals.start(tolerances, self.stamp + self._executor.trajectory.duration)

    def goal_verdict(self, number: int) -> Verdict | None:
        """Return how a goal of :meth:`follow_joint_trajectory` ended; None while it is active."""
        return self._goals.verdict(number)

    def path(self, poses: np.ndarray, times: Sequence[int] = (), frame: str = 'base') -> None:
        """Pass tool poses in straight lines; see :func:`~ur5_ros.control.planning.plan_path`."""
        self._plan('path', planning.plan_path, poses, times, frame)

    def target_wrench(self, force: Sequence[float], torque: Sequence[float],
                      frame: str = 'base') -> None:
        """
        Press with a force [N] and a torque [N m], in mode ``cartesian_impedance``.

        Parameters
        ----------
        force, torque : array_like, shape (3,)
            Of the tool on its surroundings, at the origin of ``tool0``.
        frame : str
            Axes: ``base``, ``base_link``, or ``tool0`` as it stands now.

        Raises
        ------
        InputError
            If the mode is another, no state has come, the frame is unknown or a number is not
            finite.

        """
        with self._requests.counted('target_wrench'):
            if self._validator.last is None:
                raise InputError(NO_STATE)
            self._torque.set_target_wrench(planning.desired_wrench(
                self._settings, self._validator.last, force, torque, frame))

    def change(self, changes: Mapping[str, Any]) -> None:
        """
        Change live parameters, all of them or none; they act from the next state on.

        Parameters
        ----------
        changes : mapping
            Names and new values.

        Raises
        ------
        InputError
            If one is unknown, not live, or its value is refused.

        """
        parameters = changed(self.parameters, changes)
        settings = settings_from(parameters, self.arm, self._rate)
        self._torque.set_parameters(parameters, settings, changes)
        self._settings, self.parameters = settings, parameters

    def lose_states(self) -> None:
        """Report 'waiting for states' until the next one comes; a goal of the action ends."""
        self._waiting = True
        if self._goals.active:
            self._goals.end(Verdict(ResultCode.INVALID_GOAL, 'states stopped coming'))
            self._plan('hold, since states stopped coming', planning.plan_stop)

    def status(self) -> dict[str, Any]:
        """Return the values of the diagnostics: numbers and texts."""
        requests = self._requests
        return {
            'state': self._status(),
            'detail': requests.stopped or requests.refused or self._executor.name,
            'last_refusal': requests.last_refusal,
            'last_doubt': self._validator.sentence,
            'arm': self.arm.name,
            'mode': self._settings.mode,
            'effort_convention': self.parameters.effort_convention,
            'experiment': self.parameters.experiment,
            'refused_inputs': requests.refusals,
            **self._counts,
            **describe(self._output, self._validator.last, self._executor, self.arm,
                       self._settings.mode),
        }

    @property
    def law(self) -> TorqueLaw | CheckedLaw:
        """The law in force."""
        return self._torque.law

    @property
    def stamp(self) -> int:
        """Stamp of the last output [ns]; 0 before the first."""
        return 0 if self._output is None else self._output.stamp

    @property
    def last(self) -> tuple[ArmState | None, ControlOutput | None]:
        """The last accepted state and the last output; None before the first."""
        return self._validator.last, self._output

    def _plan(self, name: str, planner: Callable[..., planning.Plan], *arguments: Any) -> None:
        self._requests.plan(name, planner, self._settings, self._output, *arguments)

    def _take_over(self, state: ArmState, status: StateStatus) -> None:
        """Start from a measured state: come to rest and hold, or start the experiment."""
        first = status is StateStatus.FIRST
        since = '' if first else f', since {self._validator.sentence}'
        rest = self._requests.take_over(state, self._settings, since)
        if first and self.parameters.autostart and self.experiment:
            self._requests.autostart(rest, state.stamp, self._settings, self.experiment)

    def _watch_limits(self, state: ArmState) -> None:
        """Stop smoothly when a joint passes a limit of the arm in position or speed."""
        joint = joint_beyond(state, self.arm.limits)
        if joint is not None and not self._beyond:
            self._requests.stop(
                'stop', state.stamp, self._settings.motion_limits,
                f'{self._names[joint]} at {state.q[joint]:.4f} rad, {state.qd[joint]:.4f} rad/s')
        self._beyond = joint is not None

    def _status(self) -> str:
        return status_of(self._waiting, self._requests.stopped, self._executor.moving,
                         self._requests.refused)
