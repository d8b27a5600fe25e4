r"""
The plant's scheme: what PyBullet does not model, added as torque, one physics step at a time.

.. math::

    (M + I_a)(\dot q' - \dot q)/h + C \dot q + g + D \dot q' + f(\dot q') - J^T w - \tau = 0

M, C, g and J are PyBullet's, at the state before the step.
"""

import struct
from typing import NamedTuple

import numpy as np

from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.friction import WORK, kernels

#: No joint is concerned.
NO_JOINTS = np.zeros(6, dtype=bool)
NO_JOINTS.flags.writeable = False

#: Lengths of the kernel's input (M, C qd + g, q, qd, torque) and of its working space.
STATE, WORKING = 60, 66 + WORK
_write = struct.Struct(f'{STATE}d').pack_into


class Effects(NamedTuple):
    """What acts on the joints besides the bodies, gravity and the motors' torque."""

    armature: np.ndarray
    """Rotor inertia Ia on the diagonal of M [kg m^2], shape (6,)."""
    viscous: np.ndarray
    """Viscous friction D [N m s/rad], shape (6,)."""
    coulomb: np.ndarray
    """Coulomb friction [N m], shape (6,)."""
    wrench: np.ndarray
    """Force [N] and torque [N m] at the origin of ``tool0``, in ``base``, shape (6,)."""
    lower: np.ndarray
    """Stops [rad], shape (6,); infinite = none."""
    upper: np.ndarray
    """Stops [rad], shape (6,); infinite = none."""


class Joints(NamedTuple):
    """Joint state as PyBullet takes and gives it."""

    q: list[float]
    qd: list[float]


class PlantIntegrator:
    """
    The scheme of one set of effects, with what does not change from step to step worked out.

    Parameters
    ----------
    effects : Effects
        What acts beside the bodies, gravity and the motors.
    step_time : float
        h [s].

    """

    def __init__(self, effects: Effects, step_time: float):
        self._effects = effects
        self._pushed = bool(effects.wrench.any())
        self._given = np.concatenate([
            effects.armature / step_time + effects.viscous, effects.viscous, effects.coulomb,
            effects.lower, effects.upper, [step_time]])
        self._state, self._work, self._torque = np.empty(STATE), np.empty(WORKING), np.empty(6)
        self._page = self._state.data.cast('B')
        self._held = np.zeros(6, dtype=bool)
        self.none = not (self._pushed or self._given[:18].any())
        """Whether PyBullet's own step under the motors' torque is the whole truth."""
        if not self.none:
            kernels().scheme_torque.prepare()

    def engine_torque(self, arm: BulletArm, joints: Joints,
                      tau: np.ndarray) -> tuple[list[float], np.ndarray]:
        """
        Return the torque that makes PyBullet's next step the step of the scheme.

        Parameters
        ----------
        arm : BulletArm
            Where M, C qd + g and J come from.
        joints : Joints
            State before the step.
        tau : numpy.ndarray, shape (6,)
            Torque of the motors [N m].

        Returns
        -------
        torque : list of float
            M (qd' - qd) / h + C qd + g [N m].
        held : numpy.ndarray, shape (6,), bool
            The joints that a stop holds back in this step.

        """
        rows, bias = arm.mass_and_bias(joints.q, joints.qd)
        if self._pushed:
            tau = tau + tool_torque(arm, joints, self._effects)
        _write(self._page, 0, *rows[0], *rows[1], *rows[2], *rows[3], *rows[4], *rows[5], *bias,
               *joints.q, *joints.qd, *tau)
        compiled = kernels()
        given = self._state, self._given, self._work, self._torque, self._held
        try:
            code = compiled.scheme_torque.single(*given)
        except TypeError:  # not compiled yet
            code = compiled.scheme_torque.run(1, [], [], given)
        if code == compiled.FAILED:
            raise ArithmeticError('the resistance of the joints was not found')
        return self._torque.tolist(), self._held.copy() if code == compiled.HELD else NO_JOINTS


def tool_torque(arm: BulletArm, joints: Joints, effects: Effects) -> np.ndarray | float:
    """Return J^T w [N m]."""
    return arm.jacobian(joints.q).T @ effects.wrench if effects.wrench.any() else 0.0
