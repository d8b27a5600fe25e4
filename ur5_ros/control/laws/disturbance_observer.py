"""A disturbance observer on top of any law: what the model does not explain is taken off."""

import numpy as np

from ur5_ros.control.laws.law import Law
from ur5_ros.control.momentum_observer import MomentumObserver
from ur5_ros.signals import ArmState, Reference, Torque


class DisturbanceObserver(Law):
    r"""
    :math:`\tau = \tau_{law} - \hat d`, with d from the generalised momentum p = M qd.

    De Luca and Mattone 2003: :math:`\dot{\hat d} = K (\dot p - \tau - C^T \dot q + g - \hat d)`
    with the torque that the states report.  Promise: an error of the model that stays constant is
    gone after some 1 / K; at rest no position error is left.

    """

    def __init__(self, law: Law) -> None:
        super().__init__(law.arm, law.gains, law.parameters)
        self.law = law
        self._observer = MomentumObserver(law.arm, law.parameters.observer_gain)
        self.disturbance = np.zeros(6)
        """What the model does not explain, up to the last state [N m]."""

    def reset(self) -> None:
        """Forget the disturbance too."""
        self.law.reset()
        self._observer.reset()

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the law's torque without the disturbance, which counts as feedback."""
        self.law.target_wrench = self.target_wrench
        torque = self.law(state, reference, dt)
        self.disturbance = self._observer.update(state)
        return torque._replace(total=torque.total - self.disturbance,
                               feedback=torque.feedback - self.disturbance)
