"""The paper's law, eq (11): the torque with which the error obeys e'' + Kd e' + Kp e = 0."""

import numpy as np

from ur5_ros.control import law_kernel
from ur5_ros.control.gains import Gains, error_poles, gains_from
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

__all__ = ['Gains', 'computed_torque', 'error_poles', 'gains_from']


def computed_torque(
    state: ArmState,
    reference: Reference,
    arm: ArmParameters,
    gains: Gains,
) -> Torque:
    r"""
    Return the joint torque that makes the arm follow the reference, with its parts.

    Kebria 2016, eq (11): :math:`\tau = M(q) a + C(q, \dot q) \dot q + g(q)` with
    :math:`a = \ddot q^* - K_D (\dot q - \dot q^*) - K_P (q - q^*)`; eq (12) follows for an exact
    model: :math:`\ddot e + K_D \dot e + K_P e = 0`, :math:`e = q - q^*`.

    Parameters
    ----------
    state : ArmState
        Measured positions [rad] and velocities [rad/s], manufacturer's angles.
    reference : Reference
        Wanted positions [rad], velocities [rad/s] and accelerations [rad/s^2].
    arm : ArmParameters
        The arm that the law believes in.
    gains : Gains
        KP [1/s^2] and KD [1/s].

    Returns
    -------
    Torque
        The total and the parts that it is the sum of [N m].

    """
    terms = dynamics_terms(state.q + arm.angle_offset, state.qd, arm)
    torque = np.empty((5, 6))
    given = (*terms, state.q, state.qd, *reference, gains.kp, gains.kd)
    try:
        law_kernel.parts.single(*given, torque)
    except TypeError:  # not compiled yet, or strided arrays
        law_kernel.parts.run(1, [np.ascontiguousarray(array) for array in given], [], [torque])
    return Torque(*torque)
