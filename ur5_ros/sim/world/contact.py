"""Arm and bodies of a world in contact: one physics step, and what was felt in it."""

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.config.worlds import World, base_pose
from ur5_ros.errors import InputError
from ur5_ros.model.kernels.base_parameters import GRAVITY, pack
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.integrator import NO_JOINTS, STATE, PlantIntegrator, tool_torque
from ur5_ros.sim.world import contact_kernel as kernel
from ur5_ros.sim.world.bullet_scene import NO_POINTS, BulletScene
from ur5_ros.sim.world.contact_rows import FIRST_BODY, GAP
from ur5_ros.sim.world.free_bodies import (
    BODY,
    ESCAPE_DISTANCE,
    ESCAPE_SPEED,
    POSITION,
    QUATERNION,
    VELOCITY,
)

#: Overlap at the start that rounding and the resting depth explain [m].
RESTING_OVERLAP = 1e-4

_write = struct.Struct(f'{STATE}d').pack_into
_NO_FORCE = np.zeros((0, 3))
_NO_TORQUE = (0.0,) * 6


class Contacts(NamedTuple):
    """The contacts of one physics step."""

    q: Sequence[float]
    """Six joint positions at its beginning [rad]."""
    points: np.ndarray
    """Rows with the columns of ``contact_rows``, shape (n, POINT)."""
    force: np.ndarray
    """Force on the first body of each in ``base`` [N], shape (n, 3)."""
    pairs: list[tuple[str, str]]
    """Names of both bodies."""
    torque: list[float]
    """Joint torque of all of them, six numbers [N m]."""
    acting: int = 0
    """How many have a force."""


class ContactWorld:
    """
    The free bodies of a world and the step that they and the arm take together.

    PyBullet gives M, C qd + g and where shapes touch; the step itself is solved by
    ``contact_kernel``: rotor inertia, joint friction, stops and contact at once, with all of them
    at the velocity after the step.

    """

    def __init__(self, scene: BulletScene, arm: ArmParameters):
        self.scene, self.world = scene, scene.world
        self._arm = arm
        self._packed = np.concatenate([pack(arm), arm.angle_offset])
        self._integrator: PlantIntegrator | None = None
        self._start = _initial_bodies(self.world)
        self._moving = len(self._start) > 0
        self._make_room(4)
        kernel.contact_step.prepare()
        self.reset()

    def reset(self) -> None:
        """Put the bodies where the world's file has them, at rest; forget every contact."""
        self.bodies = self._start.copy()
        """Free bodies, rows as ``contact_kernel`` lays them out."""
        self._points, self._force = NO_POINTS, _NO_FORCE
        self.contacts = Contacts((), NO_POINTS, _NO_FORCE, [], [0.0] * 6)
        """Those of the last physics step."""

    def set_gravity(self, gravity: Sequence[float]) -> None:
        """Set the gravitational acceleration, in ``base`` [m/s^2]."""
        self._packed[GRAVITY:GRAVITY + 3] = gravity
        self._integrator = None

    def place(self) -> None:
        """Give PyBullet the poses of the bodies."""
        self.scene.move(self.bodies[:, POSITION:POSITION + 7])

    def refuse_overlap(self) -> None:
        """Refuse bodies that overlap before anything has moved."""
        points, pairs = self.scene.points()
        if len(points) and points[:, GAP].min() < -RESTING_OVERLAP:
            worst = int(points[:, GAP].argmin())
            one, other = pairs[worst]
            raise InputError(f'world {self.world.name}: {one} and {other} overlap by '
                             f'{-1e3 * points[worst, GAP]:.3g} mm at the start; move the body, '
                             'or change initial_positions')

    def step(self, bullet: BulletArm, state: Sequence[float], tau: Sequence[float],
             integrator: PlantIntegrator) -> tuple[tuple[float, ...], np.ndarray]:
        """
        Take one physics step.

        ``state``: q [rad] and qd [rad/s] before the step, twelve numbers; ``tau``: six torques of
        the motors [N m].  Returned: ``values``: q [rad] and qd [rad/s] after the step, twelve
        numbers; ``held`` (6,): the joints that a stop holds back.
        """
        points, pairs = self.scene.points()
        if len(pairs) > self._most:
            self._make_room(2 * len(pairs))
        if integrator is not self._integrator:
            self._integrator = integrator
            self._constants = np.concatenate([self._packed, integrator.constants])
        q = state[:6]
        ((a, b, c, d, e, f), bias) = bullet.mass_and_bias(q, state[6:])
        external: Sequence[float] = _NO_TORQUE
        if integrator.wrench:
            external = tool_torque(bullet, q, integrator.effects).tolist()
            tau = [one + other for one, other in zip(tau, external, strict=True)]
        _write(self._page, 0, *a, *b, *c, *d, *e, *f, *bias, *state, *tau, *external)
        force = np.empty((len(pairs), 3)) if pairs else _NO_FORCE
        code = kernel.contact_step.single(self._room, self._constants, self.bodies, points,
                                          self._points, self._force, force)
        if code == kernel.FAILED:
            raise ArithmeticError('the friction of the joints was not found')
        if code == kernel.ESCAPED:
            self._refuse_flight()
        self._points, self._force = points, force
        numbers = self._out.tolist()
        self.contacts = Contacts(q, points, force, pairs, numbers[12:18], int(numbers[24]))
        values = tuple(numbers[:12])
        if self._moving:
            self.place()
        bullet.pose(numbers[:6])
        return values, np.array(numbers[18:24]) > 0.0 if code == kernel.HELD else NO_JOINTS

    def objects(self) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Return name, position [m] and quaternion (x, y, z, w) of every free body, in base."""
        return [(name, body[POSITION:POSITION + 3].copy(), body[QUATERNION:QUATERNION + 4].copy())
                for name, body in zip(self.scene.names[FIRST_BODY:], self.bodies,
                                      strict=True)]

    def _make_room(self, contacts: int) -> None:
        """Make the space of a step with so many contacts."""
        self._most = contacts
        self._room = np.zeros(kernel.space(len(self._start), contacts))
        self._out = self._room[kernel.OUT:kernel.OUT + kernel.OUTPUT]
        self._page = self._room.data.cast('B')

    def _refuse_flight(self) -> None:
        """Put a body that flew away back to rest; raise ArithmeticError with its name."""
        far = ~(np.abs(self.bodies[:, POSITION:POSITION + 3]).max(axis=1) < ESCAPE_DISTANCE)
        fast = ~(np.abs(self.bodies[:, VELOCITY:VELOCITY + 6]).max(axis=1) < ESCAPE_SPEED)
        for i in np.flatnonzero(far | fast):
            name = self.scene.names[FIRST_BODY + i]
            self.bodies[i] = self._start[i]
            self.place()
            raise ArithmeticError(f'body {name} flew away and was put back')


def _initial_bodies(world: World) -> np.ndarray:
    rows = []
    for body in world.bodies:
        if body.free:
            pose = base_pose(body, world.frame)
            rows.append([body.mass, *body.moments, *pose[:3, 3],
                         *quaternion_of(pose[:3, :3]), *[0.0] * 6])
    return np.array(rows, dtype=float).reshape(-1, BODY)
