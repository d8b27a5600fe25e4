"""The arm as numbers: geometry, inertia, limits, one record that every function takes last."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ur5_ros.model.friction import JointFriction
from ur5_ros.model.kernels.base_parameters import pack

#: The twist angles that all UR arms share (standard DH) [rad].
UR_TWIST = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)


@dataclass(frozen=True, eq=False)
class Payload:
    """A rigid body fixed to the tool; the default weighs nothing."""

    mass: float = 0.0
    """Mass [kg]."""
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """Centre of mass in ``tool0`` [m], shape (3,)."""
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    """Inertia tensor about the centre of mass, axes of ``tool0`` [kg m^2], shape (3, 3)."""


@dataclass(frozen=True, eq=False)
class Limits:
    """What the joints may do; infinite where nothing limits them."""

    lower: np.ndarray
    """Lowest position, manufacturer's angles [rad], shape (6,)."""
    upper: np.ndarray
    """Highest position, manufacturer's angles [rad], shape (6,)."""
    velocity: np.ndarray
    """Highest speed [rad/s], shape (6,)."""
    effort: np.ndarray
    """Highest joint torque [N m], shape (6,)."""


@dataclass(frozen=True, eq=False)
class ArmParameters:
    """
    Everything that the equations need to know of an arm.

    Link frames are those of the standard (distal) DH convention.  Link ``i`` is the body that
    joint ``i`` moves; the payload is kept apart and merged into link 6 by :attr:`bodies`.

    """

    name: str
    a: np.ndarray
    """DH link lengths [m], shape (6,); a2 and a3 may have either sign."""
    d: np.ndarray
    """DH link offsets [m], shape (6,)."""
    alpha: np.ndarray
    """DH twists [rad], shape (6,); those of :data:`UR_TWIST`."""
    angle_offset: np.ndarray
    """q_model = q_UR + angle_offset [rad], shape (6,)."""
    mass: np.ndarray
    """Link masses [kg], shape (6,)."""
    com: np.ndarray
    """Centres of mass in the link frames [m], shape (6, 3)."""
    inertia: np.ndarray
    """Tensors about the centres of mass, axes of the link frames [kg m^2], shape (6, 3, 3)."""
    armature: np.ndarray
    """Reflected rotor inertia on the diagonal of M [kg m^2], shape (6,)."""
    gravity: np.ndarray
    """Gravitational acceleration in ``base`` [m/s^2], shape (3,)."""
    limits: Limits
    payload: Payload = field(default_factory=Payload)
    calibration: np.ndarray | None = None
    """Chain of one robot's own calibration, shape (6, 4, 4): poses follow it, the dynamics the DH
    table; see :mod:`ur5_ros.model.calibration`."""
    friction: JointFriction = field(default_factory=JointFriction)
    """What resists the joints' motion; no term of eq (6), which knows no friction."""
    torque_constant: np.ndarray | None = None
    """Joint torque that a motor current makes [N m/A], shape (6,); None where not known."""
    unexplained_torque: np.ndarray | None = None
    """Torque that model and friction left unexplained where nothing touched the arm, RMS [N m],
    shape (6,); None where not known."""

    def __post_init__(self):
        _check(self)
        for value in (*vars(self).values(), *vars(self.limits).values(),
                      *vars(self.payload).values()):
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def bodies(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Return mass (6,), centre of mass (6, 3) and tensor (6, 3, 3) of the links, payload merged.

        The payload joins link 6 by the parallel-axis theorem.

        """
        if self.payload.mass == 0.0:
            return self.mass, self.com, self.inertia
        mass, com, inertia = self.mass.copy(), self.com.copy(), self.inertia.copy()
        mass[5] = self.mass[5] + self.payload.mass
        com[5] = (self.mass[5] * self.com[5] + self.payload.mass * self.payload.com) / mass[5]
        inertia[5] = (
            self.inertia[5] + _steiner(self.mass[5], self.com[5] - com[5])
            + self.payload.inertia + _steiner(self.payload.mass, self.payload.com - com[5])
        )
        return mass, com, inertia

    @cached_property
    def constants(self) -> np.ndarray:
        """Return the numbers that the kernels read (:mod:`.kernels.base_parameters`)."""
        return pack(self)

    @property
    def has_tensors(self) -> bool:
        """Whether every link is an extended body, so that a simulator can move it."""
        return bool(np.all(np.linalg.eigvalsh(self.inertia) > 0.0))


def with_payload(
    arm: ArmParameters,
    mass: float,
    com: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0),
    inertia: np.ndarray | None = None,
) -> ArmParameters:
    """
    Return the arm with another payload at its tool.

    ``arm``: the arm; its own payload is replaced; ``mass``: payload mass [kg], not negative;
    ``com`` (3,): centre of mass in ``tool0`` [m]; ``inertia`` (3, 3): tensor about the centre of
    mass, axes of ``tool0`` [kg m^2]; a point mass by default.
    """
    tensor = np.zeros((3, 3)) if inertia is None else np.array(inertia, dtype=float)
    return replace(arm, payload=Payload(float(mass), np.array(com, dtype=float), tensor))


def _steiner(mass: float, r: np.ndarray) -> np.ndarray:
    return mass * (np.dot(r, r) * np.eye(3) - np.outer(r, r))


def _check(arm: ArmParameters) -> None:
    shapes = {
        'a': (6,), 'd': (6,), 'alpha': (6,), 'angle_offset': (6,), 'mass': (6,), 'com': (6, 3),
        'inertia': (6, 3, 3), 'armature': (6,), 'gravity': (3,),
    }
    for name, shape in shapes.items():
        value = getattr(arm, name)
        if value.shape != shape or value.dtype != np.float64:
            raise ValueError(
                f'{arm.name}: {name} has shape {value.shape} and type {value.dtype}; '
                f'give {shape} float64')
        if not np.all(np.isfinite(value)):
            raise ValueError(f'{arm.name}: {name} holds {value[~np.isfinite(value)][0]}; '
                             'give finite numbers')
    if np.max(np.abs(arm.alpha - UR_TWIST)) > 1e-9:
        raise ValueError(f'{arm.name}: alpha is {arm.alpha.tolist()}; the closed form holds for '
                         'the UR twists [pi/2, 0, 0, pi/2, -pi/2, 0] only')
    for name, value in (('a', arm.a[[0, 3, 4, 5]]), ('d', arm.d[[1, 2]])):
        if np.any(value):
            which = 'a1, a4, a5, a6' if name == 'a' else 'd2, d3'
            raise ValueError(f'{arm.name}: {which} are {value.tolist()} m; the closed form holds '
                             'where they are zero')
    if abs(arm.a[1]) < 1e-6 or abs(arm.a[2]) < 1e-6:
        raise ValueError(f'{arm.name}: a2, a3 are {arm.a[1]}, {arm.a[2]} m; '
                         'both must differ from zero')
    for i, mass in enumerate(arm.mass):
        if mass <= 0.0:
            raise ValueError(f'{arm.name}: mass of link {i + 1} is {mass} kg; give more than zero')
        _check_tensor(f'{arm.name}: inertia of link {i + 1}', arm.inertia[i])
        if not np.any(arm.inertia[i]) and np.any(arm.armature <= 0.0):
            raise ValueError(f'{arm.name}: link {i + 1} is a point mass and the armature is '
                             f'{arm.armature.tolist()} kg m^2; point masses need rotor inertia '
                             'on every joint, or M is singular')
    if np.any(arm.armature < 0.0):
        raise ValueError(f'{arm.name}: armature holds {arm.armature.min()} kg m^2; '
                         'give zero or more')
    for name in ('torque_constant', 'unexplained_torque'):
        value = getattr(arm, name)
        if value is not None and not (value.shape == (6,) and (value > 0.0).all()
                                      and np.isfinite(value).all()):
            raise ValueError(f'{arm.name}: {name} is {value.tolist()}; give six numbers above '
                             'zero')
    _check_payload(arm)
    _check_limits(arm)
    _check_calibration(arm)


def _check_calibration(arm: ArmParameters) -> None:
    if arm.calibration is None:
        return
    if arm.calibration.shape != (6, 4, 4) or not np.all(np.isfinite(arm.calibration)):
        raise ValueError(f'{arm.name}: calibration has shape {arm.calibration.shape}; give six '
                         'transforms of finite numbers')
    if np.any(arm.angle_offset):
        raise ValueError(f"{arm.name}: calibration is of the manufacturer's angles; the arm has "
                         f'angle_offset {arm.angle_offset.tolist()}: give one without')


def _check_payload(arm: ArmParameters) -> None:
    load = arm.payload
    if not np.isfinite(load.mass) or load.mass < 0.0:
        raise ValueError(f'{arm.name}: payload mass is {load.mass} kg; give zero or more')
    if load.com.shape != (3,) or not np.all(np.isfinite(load.com)):
        raise ValueError(f'{arm.name}: payload com is {load.com.tolist()}; '
                         'give three finite numbers [m]')
    if load.inertia.shape != (3, 3):
        raise ValueError(f'{arm.name}: payload inertia has shape {load.inertia.shape}; '
                         'give (3, 3) [kg m^2]')
    _check_tensor(f'{arm.name}: payload inertia', load.inertia)
    if load.mass == 0.0 and np.any(load.inertia):
        raise ValueError(f'{arm.name}: payload has a tensor and no mass; give it a mass')


def _check_limits(arm: ArmParameters) -> None:
    limits = arm.limits
    for name in ('lower', 'upper', 'velocity', 'effort'):
        value = getattr(limits, name)
        if value.shape != (6,) or np.any(np.isnan(value)):
            raise ValueError(f'{arm.name}: limits.{name} is {value.tolist()}; give six numbers')
    for i in range(6):
        if limits.lower[i] >= limits.upper[i]:
            raise ValueError(f'{arm.name}: limits of joint {i + 1} are {limits.lower[i]} to '
                             f'{limits.upper[i]} rad; the lower must be less than the upper')
        for name, unit in (('velocity', 'rad/s'), ('effort', 'N m')):
            value = getattr(limits, name)[i]
            if value <= 0.0:
                raise ValueError(f'{arm.name}: {name} limit of joint {i + 1} is {value} {unit}; '
                                 'give more than zero')


def _check_tensor(what: str, tensor: np.ndarray) -> None:
    if not np.all(np.isfinite(tensor)):
        raise ValueError(f'{what} holds a number that is not finite')
    if np.max(np.abs(tensor - tensor.T)) > 1e-12:
        raise ValueError(f'{what} is not symmetric; give a symmetric tensor')
    low, middle, high = np.linalg.eigvalsh(tensor)
    if not np.any(tensor):
        return
    if low <= 0.0:
        raise ValueError(f'{what} has a principal moment of {low:.6g} kg m^2; '
                         'give more than zero')
    if low + middle < high * (1.0 - 1e-6):
        raise ValueError(f'{what} has principal moments {low:.6g}, {middle:.6g}, {high:.6g} '
                         'kg m^2; no body has one larger than the sum of the others')
