"""Computed torque with an integral: what the model lacks is learnt where the arm stands still."""

from ur5_ros.control.laws.law import model_terms, torque_of
from ur5_ros.control.laws.pid import IntegralLaw
from ur5_ros.signals import ArmState, Reference, Torque


class ComputedTorqueIntegral(IntegralLaw):
    r"""
    :math:`\tau = M (\ddot q^* - K_D \dot e - K_P e - K_I \int e\,dt) + C \dot q + g`.

    Lewis, Dawson and Abdallah 2004, section 4.4.  Promise: with an exact model
    :math:`\dddot e + K_D \ddot e + K_P \dot e + K_I e = 0`, stable where KD KP > KI joint by
    joint; with a wrong model no position error is left at rest.

    """

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque; the integral is part of the feedback."""
        error, kp, kd = state.q - reference.q, *self.gains
        integral = self._integral.add(error, dt)
        M, C, g = model_terms(state, self.arm)
        feedback = M @ (-kp @ error - kd @ (state.qd - reference.qd) - self._ki @ integral)
        torque = torque_of(M @ reference.qdd, feedback, C @ state.qd, g)
        self._integral.total = torque.total
        return torque
