"""The controller's parameters as the values that the law and the plans use."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.parameters import CONTROL_PARAMETERS, HOME, check
from ur5_ros.control.cartesian_impedance import (
    CartesianImpedanceLaw,
    Impedance,
    check_sampled_impedance,
    impedance_from,
)
from ur5_ros.control.computed_torque import UNWEIGHTED_MODES, TorqueLaw
from ur5_ros.control.gains import Gains, gains_from, sampled_radius
from ur5_ros.control.point_to_point import MotionLimits
from ur5_ros.control.tolerances import Tolerances, default_tolerances
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: Tables of motions are made for this many control periods a second where none is given [Hz]; the
#: periods of 500, 250, 200, 125, 100 Hz lie on the same grid.
DEFAULT_RATE = 1000


_NO_WRENCH = np.zeros(6)
_NO_WRENCH.flags.writeable = False


class Settings(NamedTuple):
    """Everything that a control period or a plan needs besides the state."""

    arm: ArmParameters
    control_rate: int
    mode: str
    gains: Gains
    gravity_excluded: bool
    motion_limits: MotionLimits
    max_joint_jump: float
    singularity_margin: float
    tool_speed: float
    torque_rate_limit: float
    """[N m/s]; infinite where there is none."""
    allow_nonzero_end_velocity: bool
    tolerances: Tolerances
    max_state_jump: float
    prefix: str
    impedance: Impedance
    guard_force: float
    """[N]; zero where nothing ends a path."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints with their prefix."""
        return [self.prefix + name for name in JOINT_NAMES]

    def law(self) -> TorqueLaw | CartesianImpedanceLaw:
        """Return the law of the mode, with its constants packed."""
        if self.mode == 'cartesian_impedance':
            return CartesianImpedanceLaw(self.arm, self.impedance, self.gravity_excluded,
                                         self.max_state_jump)
        return self.joint_law()

    def joint_law(self) -> TorqueLaw:
        """Return the law of a mode that works in joints."""
        return TorqueLaw(self.mode, self.arm, self.gains, self.gravity_excluded,
                         self.max_state_jump)


def settings_from(
    parameters: ControlParameters,
    arm: ArmParameters,
    control_rate: int | None,
    target_wrench: np.ndarray = _NO_WRENCH,
) -> Settings:
    """
    Return the settings of a complete set of parameters.

    Parameters
    ----------
    parameters : ControlParameters
        All of them.
    arm : ArmParameters
        The law's arm.
    control_rate : int or None
        Control periods a second [Hz], where known.
    target_wrench : numpy.ndarray, shape (6,)
        What the tool should press with in mode cartesian_impedance [N], [N m], in base.

    Returns
    -------
    Settings
        Checked settings.

    Raises
    ------
    InputError
        If the gains are not stable, or held torques would shake the arm in the mode.

    """
    gains = gains_from(parameters.kp, parameters.kd)
    mode = parameters.mode
    rate = control_rate or DEFAULT_RATE
    impedance = impedance_from(parameters, target_wrench)
    if mode == 'cartesian_impedance':
        check_sampled_impedance(impedance, arm, rate)
    else:
        check_sampled(mode, gains, arm, rate)
    speed = np.minimum(_six(parameters.max_velocity), arm.limits.velocity)
    return Settings(
        arm=arm,
        control_rate=rate,
        mode=mode,
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
        impedance=impedance,
        guard_force=parameters.guard_force,
    )


def check_sampled(mode: str, gains: Gains, arm: ArmParameters, control_rate: int) -> None:
    """
    Refuse gains with which the loop, stable in continuous time, shakes itself at this rate.

    A torque held for a period h takes more than the speed it should brake when
    h Kd / M > 2: soon so on a wrist without rotor inertia, in the modes that do not weigh by M.

    Parameters
    ----------
    mode : str
        The law.
    gains : Gains
        Its gains.
    arm : ArmParameters
        The law's arm.
    control_rate : int
        Control periods a second [Hz].

    Raises
    ------
    InputError
        Naming the joint and, in the modes without M, the largest damping that it stands.

    """
    if mode not in UNWEIGHTED_MODES:
        radius = sampled_radius(gains, None, 1.0 / control_rate)
        if radius >= 1.0:
            raise InputError(f'kp, kd make the loop unstable when sampled at {control_rate} Hz '
                             f'(spectral radius {radius:.4g}); lower kd below {control_rate} 1/s')
        return
    inertia = inertia_matrix(np.array(HOME) + arm.angle_offset, arm)
    radius = sampled_radius(gains, inertia, 1.0 / control_rate)
    if radius < 1.0:
        return
    # a torque on one joint alone accelerates it by the inverse of M
    largest = control_rate / np.diag(np.linalg.inv(inertia))
    joint = int((np.diag(gains.kd) / largest).argmax())
    if gains.kd[joint, joint] <= largest[joint]:
        raise InputError(f'mode {mode} sampled at {control_rate} Hz is unstable (spectral radius '
                         f'{radius:.4g}); lower kp')
    raise InputError(
        f'mode {mode} sampled at {control_rate} Hz is unstable: kd of {JOINT_NAMES[joint]} is '
        f'{gains.kd[joint, joint]:g} N m s/rad; for arm {arm.name} give at most about '
        f'[{", ".join(map(_two_digits, largest))}]')


def changed(parameters: ControlParameters, changes: Mapping[str, Any]) -> ControlParameters:
    """
    Return the parameters with some changed while the node runs.

    Parameters
    ----------
    parameters : ControlParameters
        The values now.
    changes : mapping
        New values of parameters that are live.

    Returns
    -------
    ControlParameters
        A complete new set.

    Raises
    ------
    InputError
        If a name is unknown, only read at the start, or a value is wrong.

    """
    known = {parameter.name: parameter for parameter in CONTROL_PARAMETERS}
    new = {}
    for name, value in changes.items():
        if name not in known:
            raise InputError(f'unknown parameter {name!r}')
        if not known[name].live:
            raise InputError(f'{name} is read at the start only; restart with the new value')
        new[name] = check(known[name], value)
    return parameters.replaced(new)


def _two_digits(value: float) -> str:
    return np.format_float_positional(value, 2, fractional=False, trim='-')


def _six(values: list[float]) -> np.ndarray:
    return np.broadcast_to(np.array(values, dtype=float), (6,)).copy()
