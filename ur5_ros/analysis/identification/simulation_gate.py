"""The last gate of an identified arm: it moves as an arm, for ten seconds."""

import numpy as np

from ur5_ros.model.dynamics import forward_dynamics, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Length of the simulation [s], its step [s], and gains of the computed torque.
DURATION, STEP, KP, KD = 10.0, 2e-3, 100.0, 20.0

#: A pose away from singularities, manufacturer's angles [rad], and a motion about it.
HOME = np.radians([0.0, -80.0, 80.0, -90.0, -90.0, 0.0])
AMPLITUDE, FREQUENCY = 0.4, 2.0 * np.pi * np.array([0.31, 0.29, 0.37, 0.41, 0.43, 0.47])


def simulate(arm: ArmParameters) -> float:
    """
    Return the largest tracking error of an arm under its own computed torque [rad].

    Semi-implicit Euler over :data:`DURATION`; infinite where the motion leaves the real numbers.

    """
    q, qd = HOME + arm.angle_offset, AMPLITUDE * FREQUENCY
    worst = 0.0
    for k in range(round(DURATION / STEP)):
        angle = FREQUENCY * (k * STEP)
        star = HOME + arm.angle_offset + AMPLITUDE * np.sin(angle)
        star_qd = AMPLITUDE * FREQUENCY * np.cos(angle)
        asked = (-AMPLITUDE * FREQUENCY**2 * np.sin(angle)
                 + KD * (star_qd - qd) + KP * (star - q))
        qd = qd + STEP * forward_dynamics(q, qd, inverse_dynamics(q, qd, asked, arm), arm)
        q = q + STEP * qd
        worst = max(worst, float(np.abs(q - star).max()))
        if not worst < np.pi:
            return np.inf
    return worst
