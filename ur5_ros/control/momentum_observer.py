"""The joint torque that the model does not explain, from the momentum, one state at a time."""

import numpy as np

from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState


class MomentumObserver:
    """
    The observer of :mod:`ur5_ros.analysis.momentum_observer`, one state at a time.

    ``gain``: A step of the torque shows to 63 % after its inverse [1/s].

    """

    def __init__(self, arm: ArmParameters, gain: float) -> None:
        self._arm, self._gain = arm, gain
        self.reset()

    def reset(self) -> None:
        """Begin anew: no torque, no state before."""
        self._before: tuple[int, np.ndarray, np.ndarray] | None = None
        self._estimate = np.zeros(6)

    def update(self, state: ArmState) -> np.ndarray:
        """Return the torque on the joints that the model lacks up to a state [N m]."""
        M, C, g = dynamics_terms(state.q + self._arm.angle_offset, state.qd, self._arm)
        momentum, drift = M @ state.qd, C.T @ state.qd - g
        if self._before is not None and state.stamp > self._before[0]:
            stamp, last, last_drift = self._before
            period = (state.stamp - stamp) * 1e-9
            external = (momentum - last) / period - state.effort - 0.5 * (drift + last_drift)
            self._estimate += -np.expm1(-self._gain * period) * (external - self._estimate)
        if self._before is None or state.stamp > self._before[0]:
            self._before = state.stamp, momentum, drift
        return self._estimate.copy()
