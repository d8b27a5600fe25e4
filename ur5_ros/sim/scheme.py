r"""
The plant's scheme: what PyBullet does not model, added as torque, one physics step at a time.

.. math::

    (M + I_a)(\dot q' - \dot q)/h + C \dot q + g + D \dot q' + f(\dot q') - J^T w - \tau = 0

M, C, g and J are PyBullet's, at the state before the step.
"""

from typing import NamedTuple

import numpy as np

from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.resistance import resisted_change


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
        self._step_time = step_time
        self._added = np.diag(effects.armature / step_time + effects.viscous)
        self._dry = bool(effects.coulomb.any())
        self._viscous = bool(effects.viscous.any())
        self._pushed = bool(effects.wrench.any())
        self.none = not (effects.armature.any() or self._dry or self._viscous or self._pushed)
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
        effects, h = self._effects, self._step_time
        q, qd = np.array(joints.q), np.array(joints.qd)
        M = arm.mass_matrix(joints.q)
        bias = arm.bias(joints.q, joints.qd)
        drive = tau - bias
        if self._viscous:
            drive = drive - effects.viscous * qd
        if self._pushed:
            drive = drive + tool_torque(arm, joints, effects)
        A, held = M / h + self._added, NOBODY
        delta = None if self._dry else np.linalg.solve(A, drive)
        if delta is None or not _within(q + h * (qd + delta), effects):
            delta, _ = resisted_change(A, drive, qd, effects.coulomb, (effects.lower - q) / h,
                                       (effects.upper - q) / h)
            reached = q + h * (qd + delta)
            held = (reached >= effects.upper - _TOUCH) | (reached <= effects.lower + _TOUCH)
        return (M @ (delta / h) + bias).tolist(), held if held.any() else NOBODY


def tool_torque(arm: BulletArm, joints: Joints, effects: Effects) -> np.ndarray | float:
    """Return J^T w [N m]."""
    return arm.jacobian(joints.q).T @ effects.wrench if effects.wrench.any() else 0.0


def _within(q: np.ndarray, effects: Effects) -> bool:
    return bool(((effects.lower < q) & (q < effects.upper)).all())


#: A joint this near to a stop touches it [rad]; rounding is a thousand times smaller.
_TOUCH = 1e-12
#: No joint is concerned.
NOBODY = np.zeros(6, dtype=bool)
NOBODY.flags.writeable = False
