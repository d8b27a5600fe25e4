r"""
The equation of a physics step: what PyBullet does not model, added as torque.

.. math::

    (M + I_a)(\dot q' - \dot q)/h + C \dot q + g + f(\dot q') - J^T w - \tau = 0

M, C, g and J are PyBullet's, at the state before the step; f is friction at the new velocity, as
:func:`ur5_ros.model.friction.friction_terms` has it for the state before the step.
"""

import struct
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.model.friction import JointFriction
from ur5_ros.model.kernels.kernel_cache import seems_cached
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.friction import WORK, kernels

#: No joint is concerned.
NO_JOINTS = np.zeros(6, dtype=bool)
NO_JOINTS.flags.writeable = False

#: Length of the kernel's input (M, C qd + g, q, qd, torque, J^T w), rows of its working space.
STATE, WORKING = 66, 12 + WORK
_write = struct.Struct(f'{STATE}d').pack_into
_ZEROS = np.zeros(6)


class Effects(NamedTuple):
    """What acts on the joints besides the bodies, gravity and the motors' torque."""

    armature: np.ndarray
    """Rotor inertia Ia on the diagonal of M [kg m^2], shape (6,)."""
    friction: JointFriction
    """What resists the motion of each joint."""
    wrench: np.ndarray
    """Force [N] and torque [N m] at the origin of ``tool0``, in ``base``, shape (6,)."""
    lower: np.ndarray
    """Stops [rad], shape (6,); infinite = none."""
    upper: np.ndarray
    """Stops [rad], shape (6,); infinite = none."""


class PlantIntegrator:
    """
    The torque for PyBullet under one set of effects, with its constants computed once.

    ``step_time``: h [s].

    """

    def __init__(self, effects: Effects, step_time: float):
        self.effects = effects
        self.wrench = bool(effects.wrench.any())
        """Whether a wrench acts at the tool."""
        self.constants = np.concatenate([
            effects.armature / step_time, effects.lower, effects.upper, [step_time],
            *_parts(effects.friction)])
        """What acts on the joints, as the kernels read it."""
        self._state, self._torque = np.empty(STATE), np.empty(6)
        self._work = np.empty((WORKING, 6))
        self._page = self._state.data.cast('B')
        self._held = np.zeros(6, dtype=bool)
        self._kernel: Callable[..., int] | None = None
        self.none = not (self.wrench or effects.armature.any()) and effects.friction.none
        """Whether PyBullet's own step under the motors' torque is already the plant's."""
        if not self.none:
            self._kernel = _compiled()

    def engine_torque(self, arm: BulletArm, state: Sequence[float],
                      tau: np.ndarray) -> tuple[list[float], np.ndarray]:
        """
        Return the torque that makes PyBullet's next step the step of the equation above.

        ``state``: q [rad] and qd [rad/s] before the step, twelve numbers; ``tau`` (6,): torque of
        the motors [N m].  Returned: ``torque``: M (qd' - qd) / h + C qd + g [N m]; ``held`` (6,):
        the joints that a stop holds back in this step.
        """
        q = state[:6]
        ((a, b, c, d, e, f), bias) = arm.mass_and_bias(q, state[6:])
        external = _ZEROS
        if self.wrench:
            external = tool_torque(arm, q, self.effects)
            tau = tau + external
        _write(self._page, 0, *a, *b, *c, *d, *e, *f, *bias, *state, *tau, *external)
        if self._kernel is None:
            self._kernel = _compiled()
        code = self._kernel(self._state, self.constants, self._work, self._torque, self._held)
        if code == 0:
            return self._torque.tolist(), NO_JOINTS
        if code == kernels().FAILED:
            raise ArithmeticError('the resistance of the joints was not found')
        return self._torque.tolist(), self._held.copy()


def tool_torque(arm: BulletArm, q: Sequence[float], effects: Effects) -> np.ndarray:
    """Return J^T w [N m]."""
    return arm.jacobian(q).T @ effects.wrench if effects.wrench.any() else np.zeros(6)


def _parts(friction: JointFriction) -> np.ndarray:
    """Return the parts as the kernel reads them, shape (9, 6)."""
    excess = np.where(friction.static > 0.0, friction.static - friction.coulomb, 0.0)
    return np.array([friction.viscous, friction.coulomb, excess, friction.stribeck_velocity,
                     friction.load_factor, friction.viscous_quadratic, friction.viscous_cubic,
                     friction.temperature_factor, friction.asymmetry])


def _compiled() -> Callable[..., int]:
    kernel = kernels().engine_torque
    kernel.prepare()
    return kernel.single


def kernels_seem_cached() -> bool:
    """Return whether :func:`prepare_kernels` seems to have nothing to compile; loads nothing."""
    return seems_cached(Path(__file__).with_name('integrator_kernel.py'))


def prepare_kernels() -> None:
    """Compile, or load, what friction, stops and wrenches need; any thread may call it."""
    kernels().friction.prepare()
    _compiled()
