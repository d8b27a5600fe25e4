"""The paper's law, eq (11): the torque with which the error obeys e'' + Kd e' + Kp e = 0."""

import numpy as np

from ur5_ros.control import law_kernel
from ur5_ros.control.gains import Gains, error_poles, gains_from
from ur5_ros.errors import InputError
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

_NAMES = ('state.q', 'state.qd', 'state.q', 'reference.q', 'reference.qd', 'reference.qdd')

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

    Raises
    ------
    InputError
        If an array is not of shape (6,), or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import ArmState, Gains, Reference, computed_torque, load_arm
    >>> q, zero = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2]), np.zeros(6)
    >>> gains = Gains(kp=100.0 * np.eye(6), kd=20.0 * np.eye(6))
    >>> torque = computed_torque(ArmState(0, q, zero, zero), Reference(q + 0.01, zero, zero),
    ...                          load_arm('ur5'), gains)
    >>> bool(np.allclose(torque.total, torque.feedback + torque.gravity))
    True

    """
    torque = np.empty((5, 6))
    given: tuple[np.ndarray, ...] = (state.q, state.qd, state.q, *reference)
    beside = (arm.constants, arm.angle_offset, gains.kp, gains.kd, law_kernel.UNBOUNDED,
              np.empty(law_kernel.WORK))
    try:
        special = law_kernel.law.single(*given, *beside, torque)
    except TypeError:  # not compiled yet, or other arrays than contiguous ones of float64
        given = tuple(finite_array(name, array, (6,))
                      for name, array in zip(_NAMES, given, strict=True))
        special = law_kernel.law.run(1, given, beside, [torque])
    if special:
        for name, array in zip(_NAMES, given, strict=True):
            finite_array(name, array, (6,))
        raise InputError('state and reference give a torque that is not finite; give smaller '
                         'numbers')
    return Torque(*torque)
