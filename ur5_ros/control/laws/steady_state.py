"""Where a law without an integral leaves the arm at rest."""

import numpy as np

from ur5_ros.control.gains import Gains
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters


def steady_state_error(q: np.ndarray, arm: ArmParameters, gains: Gains,
                       law_arm: ArmParameters | None = None) -> np.ndarray:
    r"""
    Return q - q* of an arm at rest under ``pd``, ``gravity_pd`` or ``impedance`` [rad].

    The spring carries the gravity that the law does not know: :math:`K_P e = \hat g - g` at the
    positions that are reached.

    ``q`` (6,): positions reached [rad]; ``gains``: KP [N m/rad]; ``law_arm``: the arm of a law
    that adds g(q); ``pd`` adds none.
    """
    known = 0.0 if law_arm is None else gravity_torque(q + law_arm.angle_offset, law_arm)
    return np.linalg.solve(gains.kp, known - gravity_torque(q + arm.angle_offset, arm))
