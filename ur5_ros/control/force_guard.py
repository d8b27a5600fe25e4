"""Guarded motion: the force at the tool, estimated by a momentum observer as states come."""

import numpy as np

from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.kinematics import jacobian
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState

#: Gain of the observer [1/s]: a step of the force shows to 63 % after 20 ms.
GAIN = 50.0
#: Singular values of J below this share of the largest say nothing of a force.
_SMALLEST = 1e-2


class ForceGuard:
    """
    The observer of :mod:`ur5_ros.analysis.momentum_observer`, one state at a time.

    Friction that the arm record does not have counts as a force: give a threshold above it.

    Parameters
    ----------
    arm : ArmParameters
        The arm.

    """

    def __init__(self, arm: ArmParameters) -> None:
        self._arm = arm
        self.reset()

    def reset(self) -> None:
        """Begin anew: no force, no state before."""
        self._before: tuple[int, np.ndarray, np.ndarray] | None = None
        self._estimate = np.zeros(6)

    def force(self, state: ArmState) -> float:
        """Return the size of the force on the tool [N] up to a state."""
        q = state.q + self._arm.angle_offset
        M, C, g = dynamics_terms(q, state.qd, self._arm)
        momentum, drift = M @ state.qd, C.T @ state.qd - g
        if self._before is not None:
            stamp, last, last_drift = self._before
            period = (state.stamp - stamp) * 1e-9
            external = (momentum - last) / period - state.effort - 0.5 * (drift + last_drift)
            self._estimate += -np.expm1(-GAIN * period) * (external - self._estimate)
        self._before = state.stamp, momentum, drift
        wrench = np.linalg.pinv(jacobian(q, self._arm).T, rcond=_SMALLEST) @ self._estimate
        return float(np.linalg.norm(wrench[:3]))
