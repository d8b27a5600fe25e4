"""The torque of the law in force: with friction feed-forward, within its limits."""

from collections.abc import Iterable

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.computed_torque import TorqueLaw, not_finite
from ur5_ros.control.friction_feedforward import friction_feedforward
from ur5_ros.control.kernel import GRAVITY, NOT_FINITE, STATE, TOTAL
from ur5_ros.control.laws.checked import CheckedLaw
from ur5_ros.control.output import ControlOutput
from ur5_ros.control.settings import Settings
from ur5_ros.control.torque_limits import limit_torque
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference

_ZERO = np.zeros(6)

#: Parameters that the law does not read.
_MOTION_PARAMETERS = frozenset({
    'max_velocity', 'max_acceleration', 'max_jerk', 'max_joint_jump', 'singularity_margin',
    'tool_speed', 'torque_rate_limit', 'allow_nonzero_velocity_at_trajectory_end', 'guard_force',
    'constraints.goal_time', 'constraints.trajectory', 'constraints.goal', 'state_timeout'})


class TorqueCommand:
    """What a state and its reference are answered with."""

    def __init__(self, arm: ArmParameters, parameters: ControlParameters,
                 settings: Settings) -> None:
        self._arm = arm
        self._target_wrench = np.zeros(6)
        self.set_parameters(parameters, settings)

    def set_parameters(self, parameters: ControlParameters, settings: Settings,
               changed: Iterable[str] | None = None) -> None:
        """Let parameters act; the law keeps its memory where none of those changed is its own."""
        feedforward = friction_feedforward(parameters, self._arm)
        if changed is None or not _MOTION_PARAMETERS.issuperset(changed):
            self.law: TorqueLaw | CheckedLaw = settings.law()
            self.set_target_wrench(self._target_wrench)
        self._feedforward, self._settings = feedforward, settings

    def set_target_wrench(self, wrench: np.ndarray) -> None:
        """Set force [N] and torque [N m] that the tool should press with, in base, shape (6,)."""
        self._target_wrench = wrench
        if isinstance(self.law, CheckedLaw):
            self.law.law.target_wrench = wrench

    def __call__(self, state: ArmState, q_before: np.ndarray, reference: Reference, stamp: int,
                 last: ControlOutput | None) -> tuple[np.ndarray, int]:
        """Return the torque with its parts, before any limit, and which bounds it exceeds."""
        limit = self._rate_limit(stamp, last)
        parts, code = self.law(state, q_before, reference, *limit)
        if self._feedforward is not None:
            parts, code = self._feedforward(parts, code, reference, *limit)
        return parts, code

    def limit(self, parts: np.ndarray, code: int, stamp: int, last: ControlOutput | None) -> str:
        """Scale the command to the limits that it exceeds; return their names."""
        limited = ''
        if code & NOT_FINITE:
            raise not_finite()
        if code & ~STATE:
            added = parts[GRAVITY] if self._settings.gravity_excluded else _ZERO
            parts[TOTAL], limited = limit_torque(parts[TOTAL], added, self._arm.limits.effort,
                                                 *self._rate_limit(stamp, last))
        if self._settings.gravity_excluded:
            parts[GRAVITY] = 0.0
        return limited

    def _rate_limit(self, stamp: int, last: ControlOutput | None) -> tuple[np.ndarray, float]:
        """Return the command before and the largest change since then [N m]."""
        rate = self._settings.torque_rate_limit
        if last is None or rate == np.inf:
            return _ZERO, np.inf
        return last.parts[TOTAL], rate * (stamp - last.stamp) * 1e-9
