"""Friction of the joints: the record of its parts, its law, and what a robot compensates of it."""

from dataclasses import dataclass, field, fields

import numpy as np

#: A joint slower than this is at rest [rad/s]; rounding leaves some 1e-17.
AT_REST = 1e-9

#: Speed from which on a robot compensates Coulomb friction in full [rad/s], below in proportion;
#: assumed: the slowest speed of a UR5e's own joint calibration.
FULL_SPEED = 0.01


@dataclass(frozen=True, eq=False)
class JointFriction:
    r"""
    What resists the motion of each joint: six numbers a part, no friction by default.

    At a speed v that is not zero the torque against the motion is

    .. math::

        T (1 + a \, \mathrm{sgn} v) \, [D v + D_2 |v| v + D_3 v^3
        + (F_c + (F_s - F_c) e^{-(v/v_s)^2} + \mu |load|) \, \mathrm{sgn} v]

    and at rest whatever is needed up to T (1 + a) (Fs + mu |load|) forwards and
    T (1 - a) (Fs + mu |load|) backwards.

    """

    viscous: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """D [N m s/rad]."""
    coulomb: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Fc [N m]."""
    static: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Fs [N m], at least Fc; 0 = Fc."""
    stribeck_velocity: np.ndarray = field(default_factory=lambda: np.full(6, 0.05))
    """vs [rad/s]: the speed at which Fs - Fc has fallen to 1/e."""
    load_factor: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """mu: the share of the transmitted torque that becomes friction."""
    viscous_quadratic: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """D2 [N m s^2/rad^2]; negative where friction grows less than the speed."""
    viscous_cubic: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """D3 [N m s^3/rad^3]."""
    temperature_factor: np.ndarray = field(default_factory=lambda: np.ones(6))
    """T: 1 at the temperature of the other numbers, less in a warm joint."""
    asymmetry: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """a: friction is 1 + a times as large forwards, 1 - a times backwards."""

    def __post_init__(self):
        for part in fields(self):
            value = getattr(self, part.name)
            if value.shape != (6,) or not np.isfinite(value).all():
                raise ValueError(f'friction.{part.name} is {value.tolist()}; '
                                 'give six finite numbers')
            value.flags.writeable = False
        _check(self)

    @property
    def none(self) -> bool:
        """Whether nothing resists, whatever the speed."""
        return not any(np.any(part) for part in (
            self.viscous, self.coulomb, self.static, self.load_factor, self.viscous_quadratic,
            self.viscous_cubic))


def friction_terms(
    friction: JointFriction, qd: np.ndarray, load: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return friction as it is at a state, for the step that follows.

    The torque against the motion is damping v + offset + level Sgn(v) at the new velocity v, with
    Sgn(0) = [-1, 1]: what depends on speed and load is taken from the state before the step, so
    that the step has exactly one solution and a joint can stick.

    ``qd`` (..., 6): joint velocities [rad/s]; ``load`` (..., 6): torque that the joints transmit
    [N m].  Returned: ``damping``, ``level``, ``offset`` (..., 6): [N m s/rad], [N m], [N m].
    """
    part, speed = friction, np.abs(qd)
    excess = np.where(part.static > 0.0, part.static - part.coulomb, 0.0)
    level = part.temperature_factor * (
        part.coulomb + excess * np.exp(-np.square(qd / part.stribeck_velocity))
        + part.load_factor * np.abs(load))
    direction = np.where(speed < AT_REST, 0.0, np.sign(qd))
    damping = (part.temperature_factor * (1.0 + part.asymmetry * direction)
               * np.maximum(_viscous(part, speed), 0.0))
    return damping, level, part.asymmetry * level


def friction_torque(friction: JointFriction, qd: np.ndarray, load: np.ndarray) -> np.ndarray:
    """
    Return the torque against a steady motion; zero at rest.

    ``qd`` (..., 6): joint velocities [rad/s]; ``load`` (..., 6): torque that the joints transmit
    [N m].  Returned: torque with the sign of the velocity [N m], (..., 6).
    """
    damping, level, offset = friction_terms(friction, qd, load)
    return np.where(np.abs(qd) < AT_REST, 0.0, damping * qd + offset + level * np.sign(qd))


def friction_compensation(
    friction: JointFriction, qd: np.ndarray, viscous_scale: np.ndarray, coulomb_scale: np.ndarray,
) -> np.ndarray:
    """
    Return what a robot adds to its motors' torque against its friction.

    It knows the viscous and the Coulomb friction at the nominal temperature, and nothing of the
    rest; at rest it adds nothing, since the direction of the motion to come is not known.

    ``qd`` (..., 6): measured joint velocities [rad/s]; ``viscous_scale``, ``coulomb_scale`` (6,):
    share of each that is compensated.  Returned: torque [N m], (..., 6).
    """
    viscous = np.maximum(_viscous(friction, np.abs(qd)), 0.0)
    return (viscous_scale * viscous * qd
            + coulomb_scale * friction.coulomb * np.clip(qd / FULL_SPEED, -1.0, 1.0))


def _viscous(friction: JointFriction, speed: np.ndarray) -> np.ndarray:
    """Return the viscous friction by the speed [N m s/rad]."""
    return friction.viscous + speed * (friction.viscous_quadratic
                                       + speed * friction.viscous_cubic)


def _check(friction: JointFriction) -> None:
    for name, low, words in (
            ('viscous', 0.0, 'zero or more'), ('coulomb', 0.0, 'zero or more'),
            ('static', 0.0, 'zero or more'), ('load_factor', 0.0, 'zero or more'),
            ('temperature_factor', 0.0, 'zero or more')):
        joint = int(np.argmin(getattr(friction, name)))
        if getattr(friction, name)[joint] < low:
            raise ValueError(f'friction.{name} of joint {joint + 1} is '
                             f'{getattr(friction, name)[joint]:g}; give {words}')
    for joint in range(6):
        if not friction.stribeck_velocity[joint] > 0.0:
            raise ValueError(
                f'friction.stribeck_velocity of joint {joint + 1} is '
                f'{friction.stribeck_velocity[joint]:g} rad/s; give more than zero (for static '
                'friction without a decay leave friction.static at 0)')
        if not abs(friction.asymmetry[joint]) < 1.0:
            raise ValueError(f'friction.asymmetry of joint {joint + 1} is '
                             f'{friction.asymmetry[joint]:g}; give more than -1 and less than 1')
        if 0.0 < friction.static[joint] < friction.coulomb[joint]:
            raise ValueError(
                f'friction.static of joint {joint + 1} is {friction.static[joint]:g} N m, below '
                f'friction.coulomb of {friction.coulomb[joint]:g} N m; give at least as much, or '
                '0 for no static friction above it')
