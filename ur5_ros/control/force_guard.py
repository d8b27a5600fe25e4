"""Guarded motion: the force at the tool, estimated by a momentum observer as states come."""

import numpy as np

from ur5_ros.control.execution import TrajectoryExecutor
from ur5_ros.control.momentum_observer import MomentumObserver
from ur5_ros.model.kinematics import jacobian
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState

#: Gain of the observer [1/s]: a step of the force shows to 63 % after 20 ms.
OBSERVER_GAIN = 50.0
#: Singular values of J below this share of the largest do not determine a force.
_SMALLEST_SINGULAR_VALUE = 1e-2


class ForceGuard:
    """
    What :class:`~ur5_ros.control.momentum_observer.MomentumObserver` gives for the tool.

    Friction that the arm record does not have counts as a force: give a threshold above it.

    """

    def __init__(self, arm: ArmParameters) -> None:
        self._arm, self._observer = arm, MomentumObserver(arm, OBSERVER_GAIN)

    def reset(self) -> None:
        """Begin anew: no force, no state before."""
        self._observer.reset()

    def exceeded(self, state: ArmState, executor: TrajectoryExecutor, limit: float) -> str:
        """Return why a path ends at a state: the force [N] is beyond the limit; else empty."""
        if executor.name != 'path' or not executor.moving:
            self.reset()
            return ''
        force = self.force(state)
        return f'path ended at {force:.4g} N, guard_force is {limit:g} N' if force > limit else ''

    def force(self, state: ArmState) -> float:
        """Return the size of the force on the tool [N] up to a state."""
        torque, q = self._observer.update(state), state.q + self._arm.angle_offset
        wrench = np.linalg.pinv(jacobian(q, self._arm).T, rcond=_SMALLEST_SINGULAR_VALUE) @ torque
        return float(np.linalg.norm(wrench[:3]))
