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

    @property
    def none(self) -> bool:
        """Tell whether PyBullet's own step under the motors' torque is the whole truth."""
        return not (self.armature.any() or self.viscous.any() or self.coulomb.any()
                    or self.wrench.any())


class Joints(NamedTuple):
    """Joint state as PyBullet takes and gives it."""

    q: list[float]
    qd: list[float]


def engine_torque(arm: BulletArm, joints: Joints, tau: np.ndarray, effects: Effects,
                  step_time: float) -> tuple[list[float], np.ndarray]:
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
    effects : Effects
        What else acts.
    step_time : float
        h [s].

    Returns
    -------
    torque : list of float
        M (qd' - qd) / h + C qd + g [N m].
    stopped : numpy.ndarray, shape (6,), bool
        The joints that a stop holds back in this step.

    """
    q, qd = np.array(joints.q), np.array(joints.qd)
    M = arm.mass_matrix(joints.q)
    bias = arm.bias(joints.q, joints.qd)
    A = M / step_time
    A[np.diag_indices(6)] += effects.armature / step_time + effects.viscous
    drive = tau - bias - effects.viscous * qd + tool_torque(arm, joints, effects)
    delta, _ = resisted_change(A, drive, qd, effects.coulomb, (effects.lower - q) / step_time,
                               (effects.upper - q) / step_time)
    reached = q + step_time * (qd + delta)
    stopped = (reached >= effects.upper - _TOUCH) | (reached <= effects.lower + _TOUCH)
    return (M @ (delta / step_time) + bias).tolist(), stopped


def tool_torque(arm: BulletArm, joints: Joints, effects: Effects) -> np.ndarray | float:
    """Return J^T w [N m]."""
    return arm.jacobian(joints.q).T @ effects.wrench if effects.wrench.any() else 0.0


#: A joint this near to a stop touches it [rad]; rounding is a thousand times smaller.
_TOUCH = 1e-12
