"""The controller's parameters as the values that the law and the plans use."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.parameters import CONTROL_PARAMETERS, check
from ur5_ros.control.computed_torque import TorqueLaw
from ur5_ros.control.gains import Gains, gains_from
from ur5_ros.control.laws.checked import CheckedLaw
from ur5_ros.control.laws.registry import law_class, make_law
from ur5_ros.control.point_to_point import MotionLimits
from ur5_ros.control.tolerances import Tolerances, default_tolerances
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: Tables of motions are made for this many control periods a second where none is given [Hz]; the
#: periods of 500, 250, 200, 125, 100 Hz lie on the same grid.
DEFAULT_RATE = 1000


class Settings(NamedTuple):
    """Everything that a control period or a plan needs besides the state."""

    parameters: ControlParameters
    """What the law and its own parameters are."""
    arm: ArmParameters
    control_rate: int
    """Control periods a second [Hz]."""
    mode: str
    gains: Gains
    gravity_excluded: bool
    """Whether commands leave g(q) to the robot."""
    motion_limits: MotionLimits
    max_joint_jump: float
    """How far a joint may turn to a target [rad]."""
    singularity_margin: float
    """Least distance of a path to a singularity, 0 to 1."""
    tool_speed: float
    """Speed along a path without stamps [m/s]."""
    torque_rate_limit: float
    """[N m/s]; infinite where there is none."""
    allow_nonzero_end_velocity: bool
    tolerances: Tolerances
    max_state_jump: float
    """How far a joint may move between two states [rad]."""
    prefix: str
    """``tf_prefix``."""
    guard_force: float
    """[N]; zero where nothing ends a path."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints with their prefix."""
        return [self.prefix + name for name in JOINT_NAMES]

    def law(self) -> TorqueLaw | CheckedLaw:
        """Return the law, with its constants packed."""
        return make_law(self.parameters, self.arm, self.gains)

    def joint_law(self) -> TorqueLaw:
        """Return the law of a compiled mode."""
        return TorqueLaw(self.mode, self.arm, self.gains, self.gravity_excluded,
                         self.max_state_jump)


def settings_from(
    parameters: ControlParameters,
    arm: ArmParameters,
    control_rate: int | None,
) -> Settings:
    """
    Return the settings of a complete set of parameters.

    ``control_rate``: control periods a second [Hz], where known.
    """
    gains = gains_from(parameters.kp, parameters.kd)
    rate = control_rate or DEFAULT_RATE
    law_class(parameters).check(gains, parameters, arm, rate)
    speed = np.minimum(_six(parameters.max_velocity), arm.limits.velocity)
    return Settings(
        parameters=parameters,
        arm=arm,
        control_rate=rate,
        mode=parameters.mode,
        gains=gains,
        gravity_excluded=parameters.effort_convention == 'gravity_excluded',
        motion_limits=MotionLimits(speed, _six(parameters.max_acceleration),
                                   _six(parameters.max_jerk)),
        max_joint_jump=parameters.max_joint_jump,
        singularity_margin=parameters.singularity_margin,
        tool_speed=parameters.tool_speed,
        torque_rate_limit=parameters.torque_rate_limit or np.inf,
        allow_nonzero_end_velocity=parameters.allow_nonzero_velocity_at_trajectory_end,
        tolerances=default_tolerances(parameters.constraints_trajectory,
                                      parameters.constraints_goal,
                                      parameters.constraints_goal_time),
        max_state_jump=parameters.max_state_jump,
        prefix=parameters.tf_prefix,
        guard_force=parameters.guard_force,
    )


def changed(parameters: ControlParameters, changes: Mapping[str, Any]) -> ControlParameters:
    """Return the parameters with some changed while the node runs."""
    known = {parameter.name: parameter for parameter in CONTROL_PARAMETERS}
    new = {}
    for name, value in changes.items():
        if name not in known:
            raise InputError(f'unknown parameter {name!r}')
        if not known[name].live:
            raise InputError(f'{name} is read at the start only; restart with the new value')
        new[name] = check(known[name], value)
    return parameters.replaced(new)


def _six(values: list[float]) -> np.ndarray:
    return np.broadcast_to(np.array(values, dtype=float), (6,)).copy()
