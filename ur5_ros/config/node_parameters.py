"""Parameters of the two nodes as typed records; :mod:`ur5_ros.config.parameters` declares them."""

from collections.abc import Mapping
from typing import Any, ClassVar, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS, Parameter, complete

Record = TypeVar('Record', bound='NodeParameters')


class NodeParameters(Struct, frozen=True, kw_only=True):
    """What both nodes have; the field of ``payload.mass`` is ``payload_mass``."""

    declared: ClassVar[tuple[Parameter, ...]] = ()

    arm: str
    bag: str
    max_bagfile_duration: float
    max_bagfile_size: int
    tf_prefix: str
    effort_convention: str
    control_rate: int
    torque_rate_limit: float
    monitor_rate: float
    hot_loop: str
    realtime_priority: int

    @classmethod
    def of(cls: type[Record], given: 'Mapping[str, Any] | Record | None' = None) -> Record:
        """
        Return a value for every parameter: the given ones checked, the others by default.

        ``given``: values by name; a record is returned as it is.
        """
        if isinstance(given, cls):
            return given
        values = complete(cls.declared, given or {})  # type: ignore[arg-type]  # no record
        return cls(**{field_of(name): value for name, value in values.items()})

    def by_name(self) -> dict[str, Any]:
        """Return the values by the names of the parameters, as bags and ROS have them."""
        return {each.name: getattr(self, field_of(each.name)) for each in self.declared}

    def changed_by_name(self) -> dict[str, Any]:
        """Return the values that are not the defaults, by the names of the parameters."""
        defaults = {each.name: each.default for each in self.declared}
        return {name: value for name, value in self.by_name().items() if value != defaults[name]}

    def replaced(self: Record, values: Mapping[str, Any]) -> Record:
        """Return the record with other values, given by name and checked already."""
        return replace(self, **{field_of(name): value for name, value in values.items()})


class SimParameters(NodeParameters, frozen=True, kw_only=True):
    """Every parameter of the simulator."""

    declared = SIM_PARAMETERS

    gui: bool
    lockstep: bool
    lockstep_timeout: float
    realtime_factor: float
    physics_rate: int
    stop_after: float
    command_timeout: float
    repeated_command_timeout: float
    forward_commands: bool
    fallback: str
    leave_torque_mode: bool
    torque_limit: list[float]
    effort_feedback: str
    torque_constant: list[float]
    overspeed_stop: bool
    initial_positions: list[float]
    initial_velocities: list[float]
    publish_clock: bool
    wrench_duration: float
    payload_mass: float
    payload_com: list[float]
    payload_inertia: list[float]
    payload_transition_time: float
    friction_viscous: list[float]
    friction_coulomb: list[float]
    friction_static: list[float]
    friction_stribeck_velocity: list[float]
    friction_load_factor: list[float]
    friction_viscous_quadratic: list[float]
    friction_viscous_cubic: list[float]
    friction_temperature_factor: list[float]
    friction_asymmetry: list[float]
    friction_compensation_viscous_scale: list[float]
    friction_compensation_coulomb_scale: list[float]
    friction_from_arm: bool
    noise_position: float
    noise_velocity: float
    delay_command_periods: int
    delay_state_periods: int
    seed: int
    gravity: list[float]
    world: str
    contact_friction: float
    contact_restitution: float
    contact_stiffness: float
    contact_damping: float
    force_torque_noise_force: float
    force_torque_noise_torque: float
    force_torque_offset: list[float]
    force_limit: float


class ControlParameters(NodeParameters, frozen=True, kw_only=True):
    """Every parameter of the controller."""

    declared = CONTROL_PARAMETERS

    mode: str
    law_file: str
    kp: list[float]
    kd: list[float]
    ki: list[float]
    adaptation_rate: float
    boundary_layer: list[float]
    disturbance_observer: bool
    observer_gain: float
    friction_feedforward: bool
    experiment: str
    autostart: bool
    max_velocity: list[float]
    max_acceleration: list[float]
    max_jerk: list[float]
    max_joint_jump: float
    singularity_margin: float
    tool_speed: float
    allow_nonzero_velocity_at_trajectory_end: bool
    constraints_goal_time: float
    constraints_trajectory: float
    constraints_goal: float
    state_timeout: float
    max_state_jump: float
    impedance_stiffness: list[float]
    impedance_damping: list[float]
    impedance_inertia: list[float]
    impedance_frame: str
    guard_force: float


def field_of(name: str) -> str:
    """Return the field of a parameter."""
    return name.replace('.', '_')
