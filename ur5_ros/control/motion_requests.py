"""Requests for motion: planned, executed or refused in words, and stopped where they fail."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ur5_ros.control.execution import TrajectoryExecutor
from ur5_ros.control.experiment import ExperimentTrajectory
from ur5_ros.control.goals import GoalMonitor
from ur5_ros.control.output import ControlOutput
from ur5_ros.control.planning import Plan
from ur5_ros.control.point_to_point import MotionLimits, smooth_stop
from ur5_ros.control.settings import Settings
from ur5_ros.control.takeover import plan_autostart, plan_rest
from ur5_ros.errors import InputError
from ur5_ros.signals import ArmState, Reference

NO_STATE = 'no state has come yet; start the robot or the simulator first'


class MotionRequests:
    """The trajectory in execution, the goal of the action, and why neither went on."""

    def __init__(self, joint_names: list[str]):
        self.executor = TrajectoryExecutor()
        self.goals = GoalMonitor(joint_names)
        self.stopped = ''
        """Why a limit or a guard stopped the motion."""
        self.refused = ''
        """The last refusal, while nothing has been executed since."""
        self.last_refusal = ''
        self.refusals = 0
        """How many requests were refused."""

    def plan(self, name: str, planner: Callable[..., Plan], settings: Settings,
             output: ControlOutput | None, *arguments: Any) -> None:
        """Plan a request from the last output's reference, and execute it."""
        with self.counted(name):
            if output is None:
                raise InputError(NO_STATE)
            plan = planner(settings, output.reference, *arguments)
        self.execute(plan, name, output.stamp)

    @contextmanager
    def counted(self, name: str) -> Iterator[None]:
        """Count a refusal inside the block and keep its reason."""
        try:
            yield
        except InputError as refusal:
            self.refusals += 1
            self._refuse(name, refusal)
            raise

    def execute(self, plan: Plan, name: str, stamp: int) -> None:
        """Execute a plan from a stamp [ns] on; an active goal ends."""
        self.goals.preempt(name)
        self.executor.execute(plan.trajectory, name, stamp, plan.branch)
        self.refused = self.stopped = ''

    def stop(self, name: str, stamp: int, limits: MotionLimits, why: str = '') -> None:
        """Bring the reference to rest, jerk-limited."""
        stop = smooth_stop(self.executor.at(stamp, limits), limits)
        self.execute(Plan(stop), name, stamp)
        self.stopped = why

    def take_over(self, state: ArmState, settings: Settings, since: str) -> Reference:
        """Come to rest from a measured state and hold; return the reference there."""
        rest = plan_rest(settings, state)
        self.execute(rest, f'hold{since}', state.stamp)
        return rest.trajectory.at(0)

    def autostart(self, start: Reference, stamp: int, settings: Settings,
                  experiment: ExperimentTrajectory) -> None:
        """Start the experiment, or keep why it is refused."""
        try:
            plan = plan_autostart(settings, start, experiment)
        except InputError as refusal:
            self._refuse('autostart', refusal)
        else:
            self.execute(plan, 'experiment', stamp)

    def judge(self, state: ArmState, stamp: int, limits: MotionLimits) -> None:
        """Compare state and reference for the active goal, if any; stop if it has failed."""
        if not self.goals.active:
            return
        reference = self.executor.at(stamp, limits)
        error = np.array([state.q - reference.q, state.qd - reference.qd, np.full(6, np.nan)])
        verdict = self.goals.update(error, stamp)
        if verdict is not None and verdict.code < 0:
            self.stop(f'stop: {verdict.message}', stamp, limits)

    def _refuse(self, name: str, refusal: InputError) -> None:
        self.refused = self.last_refusal = f'{name}: {refusal}'
