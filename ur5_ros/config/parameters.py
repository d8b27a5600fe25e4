"""Parameters of the two nodes, declared once for nodes, bags, loop, sweeps and documents."""

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from ur5_ros.errors import InputError
from ur5_ros.wording import number_of

HOME = [0.0, -math.pi / 2, math.pi / 2, -math.pi / 2, -math.pi / 2, 0.0]


class Parameter(NamedTuple):
    """One parameter: its default gives its type."""

    name: str
    default: Any
    description: str
    lower: float = -math.inf
    upper: float = math.inf
    """Bounds of every number; a text has none."""
    choices: tuple[str, ...] = ()
    sizes: tuple[int, ...] = ()
    """Allowed lengths, for lists."""
    live: bool = False
    """Changeable while the node runs."""


_SHARED = (
    Parameter('bag', 'auto', "Where to record: 'auto' (bags/<run>/<node>), a folder, or 'none'."),
    Parameter('max_bagfile_duration', 60.0, 'A bag file is split after this time [s of wall '
              'clock]; 0 = never.', 0.0, 86400.0),
    Parameter('max_bagfile_size', 0, 'A bag file is split at this size [bytes]; 0 = never.',
              0, 2**40),
    Parameter('tf_prefix', '', 'Put before every joint and frame name.'),
    Parameter('effort_convention', 'total', 'What a commanded effort means: the whole joint '
              'torque, or the torque without gravity, as for UR and Franka robots.',
              choices=('total', 'gravity_excluded')),
    Parameter('hot_loop', 'wait_set', 'How messages are received: one wait set, made once, on raw '
              "bytes, or rclpy's executor on message objects; both give the same bits.",
              choices=('wait_set', 'executor')),
    Parameter('realtime_priority', 0, 'Priority of the loop under SCHED_FIFO, with its memory '
              'locked and cores kept awake, for paced runs; 0 = ordinary scheduling.', 0, 99),
)

SIM_PARAMETERS = (
    Parameter('arm', 'ur5', 'Arm to simulate: a name of config/arms or a YAML file.'),
    *_SHARED,
    Parameter('gui', False, "Open PyBullet's window."),
    Parameter('lockstep', True, 'Simulated time waits for the answer to each state.'),
    Parameter('lockstep_timeout', 10.0, 'Wall-clock wait for an answer before the fallback '
              'takes over [s]; 0 = no limit.', 0.0, 86400.0),
    Parameter('realtime_factor', 1.0, 'Simulated per wall time when paced; 0 = as fast as it '
              'goes.', 0.0, 1000.0),
    Parameter('control_rate', 1000, 'Control periods a simulated second [Hz].', 1, 10000),
    Parameter('physics_rate', 1000, 'Physics steps a simulated second [Hz]; a whole multiple '
              'of control_rate.', 1, 100000),
    Parameter('stop_after', 0.0, 'Stop after this simulated time [s]; 0 = never.', 0.0, 1e7),
    Parameter('command_timeout', 0.04, 'Age at which a stamped command is too old when paced '
              '[simulated s].', 0.0, 3600.0),
    Parameter('repeated_command_timeout', 0.0, 'Paced: the same torque for longer than this is no '
              'command, as of a sender whose controller has gone [simulated s]; 0 = no limit.',
              0.0, 3600.0),
    Parameter('forward_commands', True, 'Listen to forward_effort_controller/commands; false '
              'where a controller of that name publishes there.'),
    Parameter('fallback', 'brake', 'What acts when no valid command does.',
              choices=('brake', 'gravity_compensation', 'zero_torque'), live=True),
    Parameter('leave_torque_mode', False, 'Silence ends torque mode: commands are ignored, and '
              'the fallback acts, until ~/resume_torque_mode.'),
    Parameter('torque_limit', [], "Largest commanded torque [N m]; empty = the arm's limits.",
              1e-6, 1e5, sizes=(0, 6)),
    Parameter('torque_rate_limit', 0.0, 'Highest change of a commanded torque [N m/s]; 0 = '
              'none.', 0.0, 1e9),
    Parameter('effort_feedback', 'total', 'What /joint_states has as effort: the whole torque, '
              "the torque without gravity, or the motors' current.",
              choices=('total', 'gravity_excluded', 'current')),
    Parameter('torque_constant', [10.15, 10.15, 10.13, 8.1, 8.2, 8.08], "Joint torque by current "
              "[N m/A]: a UR5e's own calibration times its gear ratio of 101.", 1e-3, 1e4,
              sizes=(6,)),
    Parameter('overspeed_stop', False, 'A joint beyond its velocity limit stops the run like a '
              'protective stop, until ~/reset.', live=True),
    Parameter('initial_positions', HOME, 'Joint positions of state 1 [rad].', -1e3, 1e3,
              sizes=(6,)),
    Parameter('initial_velocities', [0.0] * 6, 'Joint velocities of state 1 [rad/s].', -100.0,
              100.0, sizes=(6,)),
    Parameter('publish_clock', True, 'Publish /clock; false for a second simulator.'),
    Parameter('wrench_duration', 0.0, 'An external wrench ends after this simulated time [s]; '
              '0 = until a zero one comes.', 0.0, 1e7, live=True),
    Parameter('world', 'empty', 'What the arm can touch: a name of config/worlds or a YAML file; '
              'empty = nothing.'),
    Parameter('contact.friction', -1.0, "Friction coefficient of every body of the world; -1 = "
              "the file's.", -1.0, 100.0),
    Parameter('contact.restitution', -1.0, "Restitution of every body; -1 = the file's.", -1.0,
              1.0),
    Parameter('contact.stiffness', -1.0, "Stiffness of every body's contact [N/m]; 0 = rigid, "
              "-1 = the file's.", -1.0, 1e12),
    Parameter('contact.damping', -1.0, "Damping of every body's contact [N s/m]; -1 = the "
              "file's.", -1.0, 1e9),
    Parameter('force_torque.noise_force', 0.0, 'Standard deviation of the measured force [N].',
              0.0, 1e6, live=True),
    Parameter('force_torque.noise_torque', 0.0, 'Standard deviation of the measured torque '
              '[N m].', 0.0, 1e6, live=True),
    Parameter('force_torque.offset', [0.0] * 6, 'What the sensor shows without a load: force [N], '
              'torque [N m].', -1e6, 1e6, sizes=(6,), live=True),
    Parameter('monitor_rate', 50.0, 'Rate of ~/contacts and ~/objects [Hz of simulated time]; 0 = '
              'never.', 0.0, 10000.0),
    Parameter('force_limit', 0.0, 'A larger force on the tool is a protective stop, until ~/reset '
              '[N]; 0 = none.', 0.0, 1e9, live=True),
    Parameter('payload.mass', 0.0, 'Mass fixed to the tool that the arm record does not declare '
              '[kg].', 0.0, 1000.0, live=True),
    Parameter('payload.com', [0.0] * 3, 'Its centre of mass in tool0 [m].', -10.0, 10.0,
              sizes=(3,), live=True),
    Parameter('payload.inertia', [0.0] * 6, 'Its tensor about the centre of mass, axes of tool0: '
              'xx, yy, zz, xy, xz, yz [kg m^2].', -1e3, 1e3, sizes=(6,), live=True),
    Parameter('payload.transition_time', 0.0, 'A change of payload.* acts in stages over this '
              'simulated time [s]; 0 = at once.', 0.0, 60.0, live=True),
    Parameter('friction.viscous', [0.0] * 6, 'Viscous joint friction [N m s/rad].', 0.0, 1e4,
              sizes=(6,), live=True),
    Parameter('friction.coulomb', [0.0] * 6, 'Coulomb joint friction [N m].', 0.0, 1e4,
              sizes=(6,), live=True),
    Parameter('friction.static', [0.0] * 6, 'Friction of a joint at rest [N m], at least the '
              'Coulomb friction; 0 = the Coulomb friction.', 0.0, 1e4, sizes=(6,), live=True),
    Parameter('friction.stribeck_velocity', [0.05] * 6, 'Speed at which static friction above '
              'Coulomb friction has fallen to 1/e [rad/s].', 1e-6, 100.0, sizes=(6,), live=True),
    Parameter('friction.load_factor', [0.0] * 6, 'Share of the transmitted torque (gravity, '
              'Coriolis, wrench) that becomes friction.', 0.0, 1.0, sizes=(6,), live=True),
    Parameter('friction.viscous_quadratic', [0.0] * 6, 'Viscous friction that grows with the '
              'square of the speed [N m s^2/rad^2].', -1e4, 1e4, sizes=(6,), live=True),
    Parameter('friction.viscous_cubic', [0.0] * 6, 'Viscous friction that grows with its cube '
              '[N m s^3/rad^3].', -1e4, 1e4, sizes=(6,), live=True),
    Parameter('friction.temperature_factor', [1.0] * 6, 'All friction is multiplied by it: less '
              'than 1 in a warm joint.', 0.0, 10.0, sizes=(6,), live=True),
    Parameter('friction.asymmetry', [0.0] * 6, 'Friction is 1 + this times as large forwards and '
              '1 - this times backwards.', -0.99, 0.99, sizes=(6,), live=True),
    Parameter('friction_compensation.viscous_scale', [0.0] * 6, 'Share of the viscous friction '
              'that the robot adds to the torque of a command, from the measured speed; UR ships '
              '0.9 0.9 0.8 0.9 0.9 0.9.', 0.0, 2.0, sizes=(6,), live=True),
    Parameter('friction_compensation.coulomb_scale', [0.0] * 6, 'Share of the Coulomb friction '
              'that it adds; UR ships 0.8 0.8 0.7 0.8 0.8 0.8.', 0.0, 2.0, sizes=(6,), live=True),
    Parameter('friction.from_arm', False, 'Begin with the friction of the arm file where a '
              'parameter friction.* has its default.'),
    Parameter('noise.position', 0.0, 'Standard deviation of the encoder position [rad].', 0.0,
              1.0, live=True),
    Parameter('noise.velocity', 0.0, 'Standard deviation of the measured velocity [rad/s].', 0.0,
              10.0, live=True),
    Parameter('delay.command_periods', 0, 'A command acts this many control periods later.', 0,
              1000, live=True),
    Parameter('delay.state_periods', 0, 'A state is published this many control periods later.',
              0, 1000, live=True),
    Parameter('seed', 0, 'Seed of the noise.', 0, 2**31 - 1, live=True),
    Parameter('gravity', [], "Gravitational acceleration in base [m/s^2]; empty = the arm's.",
              -1000.0, 1000.0, sizes=(0, 3), live=True),
)

CONTROL_PARAMETERS = (
    Parameter('arm', 'ur5', 'Arm of the controller: a name of config/arms or a YAML file; '
              "another one than the simulator's is the robustness experiment."),
    *_SHARED,
    Parameter('control_rate', 0, 'States a second [Hz], for a robot that does not report it; 0 = '
              'as the simulator reports, or as many stamps agree.', 0, 10000),
    Parameter('mode', 'computed_torque', 'The law.',
              choices=('computed_torque', 'gravity_pd', 'pd', 'impedance', 'pid',
                       'computed_torque_integral', 'slotine_li', 'adaptive', 'sliding_mode',
                       'cartesian_impedance'), live=True),
    Parameter('law_file', '', 'A Python file whose class Law is the law, in place of mode.'),
    Parameter('kp', [10.0], 'Position gain: 1, 6 or 36 numbers, row-major.', -1e9, 1e9,
              sizes=(1, 6, 36), live=True),
    Parameter('kd', [10.0], 'Velocity gain: 1, 6 or 36 numbers, row-major.', -1e9, 1e9,
              sizes=(1, 6, 36), live=True),
    Parameter('ki', [1.0], 'Integral gain of pid [N m/(rad s)] and of computed_torque_integral '
              '[1/s^3]: 1, 6 or 36 numbers, row-major.', -1e9, 1e9, sizes=(1, 6, 36), live=True),
    Parameter('adaptation_rate', 100.0, 'How fast mode adaptive learns [1/s^2]: about the square '
              'of a frequency.', 1e-9, 1e9, live=True),
    Parameter('boundary_layer', [0.5], 'Width of the boundary layer of mode sliding_mode, in '
              "s = e' + KD^-1 KP e [rad/s]: 1 or 6 numbers.", 1e-9, 1e6, sizes=(1, 6),
              live=True),
    Parameter('disturbance_observer', False, 'Subtract the torque that a momentum observer '
              'finds and the model does not explain, in any mode.', live=True),
    Parameter('observer_gain', 20.0, 'Bandwidth of that observer [1/s].', 1e-6, 1e4, live=True),
    Parameter('impedance.stiffness', [1000.0, 1000.0, 1000.0, 30.0, 30.0, 5.0], 'Stiffness of the '
              'tool in mode cartesian_impedance [N/m], [N m/rad]: 6 or 36 numbers, row-major.',
              -1e9, 1e9, sizes=(6, 36), live=True),
    Parameter('impedance.damping', [200.0, 200.0, 200.0, 2.0, 2.0, 0.05], 'Its damping [N s/m], '
              '[N m s/rad]: 6 or 36 numbers.', -1e9, 1e9, sizes=(6, 36), live=True),
    Parameter('impedance.inertia', [], 'Inertia that the tool shows to its reference [kg], '
              '[kg m^2]: 6 or 36 numbers; empty = that of the arm.', -1e9, 1e9,
              sizes=(0, 6, 36), live=True),
    Parameter('impedance.frame', 'tool', 'Axes of impedance.stiffness, .damping and '
              '.inertia.', choices=('tool', 'base'), live=True),
    Parameter('guard_force', 0.0, 'A path ends where the tool meets this force, as the momentum '
              'observer estimates it [N]; 0 = never.', 0.0, 1e6, live=True),
    Parameter('friction_feedforward', False, "Add the friction of the controller's arm at the "
              'desired speed to the torque.', live=True),
    Parameter('experiment', '', 'Experiment: a name of config/experiments or a YAML file.'),
    Parameter('autostart', False, 'Start the experiment at the first state answered.'),
    Parameter('max_velocity', [1.0], 'Joint speed of point-to-point motion [rad/s]: 1 or 6 '
              'numbers.', 1e-6, 100.0, sizes=(1, 6), live=True),
    Parameter('max_acceleration', [2.0], 'Joint acceleration of point-to-point motion '
              '[rad/s^2]: 1 or 6 numbers.', 1e-6, 1e4, sizes=(1, 6), live=True),
    Parameter('max_jerk', [20.0], 'Joint jerk of point-to-point motion [rad/s^3]: 1 or 6 '
              'numbers.', 1e-6, 1e6, sizes=(1, 6), live=True),
    Parameter('max_joint_jump', 3.2, 'A target whose nearest solution is further away on a '
              'joint is refused [rad].', 1e-6, 100.0, live=True),
    Parameter('singularity_margin', 0.02, 'A path that comes nearer to a singularity is '
              'refused (smallest of |sin q5|, |sin q3|, |wrist centre to axis 1| / reach).', 0.0,
              1.0, live=True),
    Parameter('tool_speed', 0.1, 'Speed along a path without stamps [m/s].', 1e-6, 10.0,
              live=True),
    Parameter('torque_rate_limit', 0.0, 'Highest change of a commanded torque [N m/s]; 0 = '
              'none.', 0.0, 1e9, live=True),
    Parameter('allow_nonzero_velocity_at_trajectory_end', False, 'As in the '
              'joint_trajectory_controller.', live=True),
    Parameter('constraints.goal_time', 2.0, 'Extra time to reach a goal [s]; 0 = no limit.', 0.0,
              1e6, live=True),
    Parameter('constraints.trajectory', 0.2, 'Largest joint error while following an action '
              'goal [rad]; 0 = none.', 0.0, 100.0, live=True),
    Parameter('constraints.goal', 0.1, 'Largest joint error at the end of an action goal [rad]; '
              '0 = none.', 0.0, 100.0, live=True),
    Parameter('state_timeout', 1.0, 'Wall-clock silence after which the states are reported '
              'missing [s].', 1e-3, 86400.0, live=True),
    Parameter('max_state_jump', 0.5, 'A joint that moves further between two states is not '
              'accepted [rad].', 1e-6, 1e3, live=True),
    Parameter('monitor_rate', 50.0, 'Rate of ~/error, ~/tool_pose, ~/reference_pose and '
              '~/torque_parts [Hz of simulated time]; 0 = never.', 0.0, 10000.0),
)


def check(parameter: Parameter, value: Any) -> Any:
    """Return ``value`` in the type of the parameter."""
    default, name = parameter.default, parameter.name
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise InputError(f'{name} is {value!r}; give true or false')
        return value
    if isinstance(default, str):
        if not isinstance(value, str):
            raise InputError(f'{name} is {value!r}; give a text')
        if parameter.choices and value not in parameter.choices:
            raise InputError(f'{name} is {value!r}; give one of: {", ".join(parameter.choices)}')
        return value
    if isinstance(default, list):
        if isinstance(value, int | float) and not isinstance(value, bool) and 1 in parameter.sizes:
            value = [value]
        if isinstance(value, str | bytes | Mapping) or not hasattr(value, '__len__'):
            raise InputError(f'{name} is {value!r}; give a list of numbers')
        if len(value) not in parameter.sizes:
            sizes = ' or '.join(str(size) for size in parameter.sizes)
            raise InputError(f'{name} has {number_of(len(value), "number")}; give {sizes}')
        return [_number(parameter, item, float) for item in value]
    return _number(parameter, value, type(default))


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the known names that are most like a wrong one, and where all of them are."""
    from difflib import get_close_matches  # of use for a wrong name alone
    alike = get_close_matches(name, known, 5, 0.4)
    found = f'the nearest are: {", ".join(alike)}; ' if alike else ''
    return f'{found}--help of the node lists all'


def complete(parameters: tuple[Parameter, ...], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a value for every parameter: the given ones checked, the others by default."""
    known = {parameter.name: parameter for parameter in parameters}
    for name in given:
        if name not in known:
            raise InputError(f'unknown parameter {name!r}; {nearest(name, known)}')
    return {name: check(parameter, given[name]) if name in given else parameter.default
            for name, parameter in known.items()}


def _number(parameter: Parameter, value: Any, kind: type) -> float | int:
    name = parameter.name
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f'{name} is {value!r}; give a number')
    if not math.isfinite(value):
        raise InputError(f'{name} is {value}; give a finite number')
    if kind is int and value != int(value):
        raise InputError(f'{name} is {value}; give a whole number')
    lower, upper = parameter.lower, parameter.upper
    if lower is not None and upper is not None and not lower <= value <= upper:
        raise InputError(f'{name} is {value}; give {lower:g} to {upper:g}')
    return kind(value)
