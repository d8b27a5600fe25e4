"""Computed torque with an integral: what the model lacks is learnt where the arm stands still."""

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains, definite_matrix
from ur5_ros.control.laws.law import Law, model_terms, torque_of
from ur5_ros.control.laws.pid import ErrorIntegral
from ur5_ros.control.laws.stability import check_integral
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque


class ComputedTorqueIntegral(Law):
    r"""
    :math:`\tau = M (\ddot q^* - K_D \dot e - K_P e - K_I \int e\,dt) + C \dot q + g`.

    Lewis, Dawson and Abdallah 2004, section 4.4.  Promise: with an exact model
    :math:`\dddot e + K_D \ddot e + K_P \dot e + K_I e = 0`, stable where KD KP > KI joint by
    joint; with a wrong model no position error is left at rest.

    """

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._ki = definite_matrix('ki', parameters.ki)
        self._integral = ErrorIntegral(arm.limits.effort)
        self.reset = self._integral.reset  # type: ignore[method-assign]

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse gains that are unstable, in continuous time or sampled."""
        super().check(gains, parameters, arm, control_rate)
        check_integral(parameters.mode, gains, definite_matrix('ki', parameters.ki), np.eye(6),
                       control_rate)

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque; the integral is part of the feedback."""
        error, kp, kd = state.q - reference.q, *self.gains
        integral = self._integral.add(error, dt)
        M, C, g = model_terms(state, self.arm)
        feedback = M @ (-kp @ error - kd @ (state.qd - reference.qd) - self._ki @ integral)
        torque = torque_of(M @ reference.qdd, feedback, C @ state.qd, g)
        self._integral.total = torque.total
        return torque
