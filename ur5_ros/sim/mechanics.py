"""The moving body: PyBullet, what is added to it, the stops, one physics step at a time."""

from collections.abc import Sequence
from operator import le
from struct import Struct
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ur5_ros.config.worlds import EMPTY_WORLD, World
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.bullet_arm import BulletArm, Joints
from ur5_ros.sim.integrator import NO_JOINTS, Effects, PlantIntegrator
from ur5_ros.sim.limits import state_bounds
from ur5_ros.sim.payload import ToolLoad, loaded_arm

if TYPE_CHECKING:
    from ur5_ros.sim.world.bullet_scene import BulletScene
    from ur5_ros.sim.world.contact import Contacts, ContactWorld

#: A state beyond this is an error: no arm moves so fast or turns so far [rad, rad/s].
_RUNAWAY = 1e6

_write = Struct('12d').pack_into


class Advance(NamedTuple):
    """What happened in some physics steps besides motion."""

    held: np.ndarray
    """The joints that a stop held back, shape (6,), bool."""
    free: bool
    """Whether every state is within the limits of position and velocity, and no stop held."""
    failure: str
    """Why a step came to nothing, such as a state that ran away; the arm then rests where it was
    before that step."""


_FREE = Advance(NO_JOINTS, True, '')


class Mechanics:
    """
    Joint state and what moves it.

    ``step_time``: length h of a physics step [s].

    """

    def __init__(self, arm: ArmParameters, step_time: float, gui: bool,
                 world: World = EMPTY_WORLD):
        self.arm = arm
        self.step_time = step_time
        scene = None if world.empty else _scene(world)
        self.bullet = BulletArm(arm, arm.gravity, step_time, gui, scene)
        self.world = None if scene is None else _contact_world(scene, arm)
        """What stands around the arm; None where there is nothing to touch."""
        self.contacts: list[Contacts] = []
        """Those of each physics step of the last :meth:`advance`."""
        self._least, self._most = (bound.tolist() for bound in state_bounds(arm))
        self._load = (ToolLoad(), arm.gravity.tolist())
        self._now: tuple[float, ...] = (0.0,) * 12

    @property
    def joints(self) -> Joints:
        """Positions [rad] and velocities [rad/s]."""
        return Joints(self._now[:6], self._now[6:])

    def set_payload(self, load: ToolLoad, gravity: list[float]) -> None:
        """
        Load the tool with a further body and set gravity; the joint state stays.

        ``gravity``: in ``base`` [m/s^2]; empty = the arm's.
        """
        given = (load, list(gravity) or self.arm.gravity.tolist())
        if given != self._load:
            self.bullet.load(loaded_arm(self.arm, *load), given[1])
            self.bullet.place(*self.joints)
            self._load = given
            if self.world is not None:
                self.world.set_gravity(given[1])
                self.world.place()

    def set_effects(self, effects: Effects) -> None:
        """Set what acts beside the bodies, gravity and the motors."""
        self.effects = effects
        integrator = PlantIntegrator(effects, self.step_time)
        self._at_stops = integrator
        self._integrator = None if integrator.none and self.world is None else integrator

    def place(self, q: Sequence[float], qd: Sequence[float]) -> None:
        """Put the joints there."""
        self._now = (*q, *qd)
        self.bullet.place(*self.joints)

    def advance(self, tau: np.ndarray, steps: int) -> Advance:
        """
        Take physics steps under a constant torque of the motors.

        ``tau`` (6,): torque of the motors [N m].
        """
        integrator, bullet, motors = self._integrator, self.bullet, tau.tolist()
        held, free, world = NO_JOINTS, True, self.world
        self.contacts = []
        for _ in range(steps):
            before, torque, at_stop = self._now, motors, NO_JOINTS
            try:
                if world is not None:
                    now, at_stop = world.step(bullet, before, motors, self._at_stops)
                    self.contacts.append(world.contacts)
                else:
                    if integrator is not None:
                        torque, at_stop = integrator.engine_torque(bullet, before, tau)
                    now = bullet.advance(torque)
                self._now = now
                if at_stop is not NO_JOINTS:
                    held, free = held | at_stop, False
                if not (all(map(le, self._least, now)) and all(map(le, now, self._most))):
                    held, free = held | self._step_at_limit(before, tau), False  # nor is NaN
            except ArithmeticError as error:
                self.place(before[:6], [0.0] * 6)
                return Advance(held, False, str(error))
        return _FREE if free else Advance(held, False, '')

    def _step_at_limit(self, before: tuple[float, ...], tau: np.ndarray) -> np.ndarray:
        """Look at a step that passed a limit; take it again where a stop has to hold."""
        held, now = NO_JOINTS, np.array(self._now)
        if not np.abs(now).max() < _RUNAWAY:  # NaN is not less either
            raise FloatingPointError('the state of the arm ran away')
        q, limits = now[:6], self.arm.limits
        if self._integrator is None and ((q < limits.lower) | (q > limits.upper)).any():
            self.place(before[:6], before[6:])  # PyBullet has no stops
            torque, held = self._at_stops.engine_torque(self.bullet, before, tau)
            self._now = self.bullet.advance(torque)
            if not np.abs(self._now).max() < _RUNAWAY:
                raise FloatingPointError('the state of the arm ran away')
        return held

    def largest_damping(self, control_rate: int) -> np.ndarray:
        """
        Return the joint damping above which a torque held for a period shakes the arm, (6,).

        Such a torque stops the joint within the period when h D / M = 1 and doubles its speed
        when h D / M = 3: D [N m s/rad], M seen by the joint at the present state.
        """
        inertia = self.bullet.mass_matrix(self.joints.q) + np.diag(self.arm.armature)
        return control_rate / np.diag(np.linalg.inv(inertia))

    def objects(self) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Return name, position [m] and quaternion (x, y, z, w) of every free body, in base."""
        return [] if self.world is None else self.world.objects()

    def reset_world(self) -> None:
        """Put the bodies of the world back; all is loaded anew, so that no old contact is kept."""
        if self.world is not None:
            self.world.reset()
            self.contacts = []
            load, gravity = self._load
            self.bullet.load(loaded_arm(self.arm, *load), gravity)

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Return q [rad] and qd [rad/s], shape (6,) each."""
        values = np.empty(12)
        _write(values.data, 0, *self._now)  # takes half the time of np.array
        return values[:6], values[6:]

    def declared_gravity(self) -> np.ndarray:
        """Return g(q) of the arm record and its declared payload, in its own gravity [N m]."""
        load, gravity = self._load
        own = self.arm.gravity.tolist()
        if gravity != own:
            self.bullet.set_gravity(own)
        tau = self.bullet.bias(self.joints.q)
        if gravity != own:
            self.bullet.set_gravity(gravity)
        if load.mass > 0.0:
            tau = tau + load.mass * (
                self.bullet.jacobian(self.joints.q, load.com)[:3].T @ self.arm.gravity)
        return tau


def _scene(world: World) -> 'BulletScene':
    from ur5_ros.sim.world.bullet_scene import BulletScene  # a plant without a world needs none
    return BulletScene(world)


def _contact_world(scene: 'BulletScene', arm: ArmParameters) -> 'ContactWorld':
    from ur5_ros.sim.world.contact import ContactWorld  # loads Numba
    return ContactWorld(scene, arm)
