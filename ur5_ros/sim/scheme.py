r"""
The plant's scheme: what PyBullet does not model, added as torque, one physics step at a time.

.. math::

    (M + I_a)(\dot q' - \dot q)/h + C \dot q + g + D \dot q' + f(\dot q') - J^T w - \tau = 0

M, C, g and J are PyBullet's, at the state before the step.
"""

import struct
from typing import NamedTuple

import numpy as np

from ur5_ros.model.compiled import B1, R1, W1, kernel
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.resistance import WORK, resist

#: A joint this near to a stop touches it [rad]; rounding is a thousand times smaller.
_TOUCH = 1e-12
#: No joint is concerned.
NOBODY = np.zeros(6, dtype=bool)
NOBODY.flags.writeable = False

#: What :func:`scheme_torque` comes to.
HELD, FAILED = 1, 2
#: Lengths of its input (M, C qd + g, q, qd, torque) and of its working space.
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


class Scheme:
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
        given = self._state, self._given, self._work, self._torque, self._held
        try:
            code = scheme_torque.single(*given)
        except TypeError:  # not compiled yet
            code = scheme_torque.run(1, [], [], given)
        if code == FAILED:
            raise ArithmeticError('the resistance of the joints was not found')
        return self._torque.tolist(), self._held.copy() if code == HELD else NOBODY


@kernel(R1, R1, W1, W1, B1)
def scheme_torque(state, given, work, torque, held):
    """Write the torque of :meth:`Scheme.engine_torque` and who is held; return what came of it."""
    m, bias, q, qd, tau = state[:36], state[36:42], state[42:48], state[48:54], state[54:60]
    added, viscous, level = given[:6], given[6:12], given[12:18]
    lower, upper, h = given[18:24], given[24:30], given[30]
    A, drive = work[:36].reshape((6, 6)), work[36:42]
    lowest, highest, delta, f = work[42:48], work[48:54], work[54:60], work[60:66]
    for i in range(6):
        drive[i] = tau[i] - bias[i] - viscous[i] * qd[i]
        lowest[i], highest[i] = (lower[i] - q[i]) / h, (upper[i] - q[i]) / h
        for j in range(6):
            A[i, j] = m[6 * i + j] / h
        A[i, i] += added[i]
    if resist(A, drive, qd, level, lowest, highest, work[66:], delta, f):
        return FAILED
    code = 0
    for i in range(6):
        reached = q[i] + h * (qd[i] + delta[i])
        held[i] = reached >= upper[i] - _TOUCH or reached <= lower[i] + _TOUCH
        if held[i]:
            code = HELD
        torque[i] = bias[i]
        for j in range(6):
            torque[i] += m[6 * i + j] * (delta[j] / h)
    return code


def tool_torque(arm: BulletArm, joints: Joints, effects: Effects) -> np.ndarray | float:
    """Return J^T w [N m]."""
    return arm.jacobian(joints.q).T @ effects.wrench if effects.wrench.any() else 0.0
