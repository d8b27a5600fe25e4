"""The paper's law, eq (11): the torque with which the error follows e'' + Kd e' + Kp e = 0."""

import numpy as np

from ur5_ros.control import kernel
from ur5_ros.control.gains import Gains
from ur5_ros.errors import InputError
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

#: Modes and their numbers in the kernel.
MODES = {'computed_torque': kernel.COMPUTED_TORQUE, 'impedance': kernel.IMPEDANCE,
         'gravity_pd': kernel.GRAVITY_PD, 'pd': kernel.PD}
#: Modes in which the gains are [N m/rad] and [N m s/rad], not weighed by M.
UNWEIGHTED_MODES = ('impedance', 'gravity_pd', 'pd')

#: More than all positions [rad] and speeds [rad/s] of an arm together.
LARGEST_STATE = 1e6

_ARGUMENTS = ('state.q', 'state.qd', 'state.q', 'reference.q', 'reference.qd', 'reference.qdd')
_ZERO = np.zeros(6)
_ZERO.flags.writeable = False


class TorqueLaw:
    """
    The law of a mode with its constants, packed for the compiled kernel.

    ``computed_torque`` is eq (11).  ``pd``: -Kp e - Kd e'.  ``gravity_pd``: the same and g(q),
    what most robots run.  ``impedance``: the same, M qdd* and C qd as well, so that the arm
    yields like a spring of stiffness Kp about a reference that it would follow by itself.

    ``max_state_jump``: largest distance of a joint between two states [rad].

    """

    def __init__(self, mode: str, arm: ArmParameters, gains: Gains,
                 gravity_excluded: bool = False, max_state_jump: float = np.inf) -> None:
        limits, largest = arm.limits, LARGEST_STATE / 13.0  # of six positions and six speeds
        lower, upper, speed = np.clip([limits.lower, limits.upper, limits.velocity],
                                      -largest, largest)
        bounds = np.concatenate([lower, upper, speed, limits.effort, [max_state_jump]])
        self.constants = (kernel.pack(MODES[mode], arm, gains, gravity_excluded, bounds),
                          np.empty(kernel.WORK))
        """Arguments of :func:`ur5_ros.control.kernel.law` between the input and the output."""
        kernel.law.prepare()

    def __call__(self, state: ArmState, q_before: np.ndarray, reference: Reference,
                 torque_before: np.ndarray = _ZERO, largest_change: float = np.inf,
                 ) -> tuple[np.ndarray, int]:
        """
        Return the torque before any limit, and which bounds it or the state exceeds.

        ``q_before`` (6,): positions in the state before [rad]; ``torque_before`` (6,): the command
        before [N m]; ``largest_change``: largest change of a joint torque since then [N m].
        Returned: rows as :class:`ur5_ros.signals.Torque` names them [N m], (5, 6); bits of
        :mod:`ur5_ros.control.kernel`; 0 where nothing is out of bounds.
        """
        torque = np.empty((5, 6))
        try:
            return torque, kernel.law.single(state.q, state.qd, q_before, *reference,
                                             torque_before, largest_change, *self.constants,
                                             torque)
        except TypeError:  # other arrays than contiguous ones of float64
            arrays = _checked(state, q_before, reference)
            return torque, kernel.law.run(
                1, arrays, (torque_before, largest_change, *self.constants), [torque])


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
        Desired positions [rad], velocities [rad/s] and accelerations [rad/s^2].
    arm : ArmParameters
        The model that the law uses.
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
    packed = kernel.pack(kernel.COMPUTED_TORQUE, arm, gains, False, kernel.UNBOUNDED)
    constants = (_ZERO, np.inf, packed, np.empty(kernel.WORK))
    try:
        code = kernel.law.single(state.q, state.qd, state.q, *reference, *constants, torque)
    except TypeError:  # not compiled yet, or other arrays than contiguous ones of float64
        code = kernel.law.run(1, _checked(state, state.q, reference), constants, [torque])
    if code:
        _checked(state, state.q, reference)
        raise not_finite()
    return Torque(*torque)


def not_finite() -> InputError:
    """Return the error for a torque that is not finite."""
    return InputError('state and reference give a torque that is not finite; give smaller numbers')


def _checked(state: ArmState, q_before: np.ndarray, reference: Reference) -> list[np.ndarray]:
    """Return the arrays for the kernel, refused by name where one is wrong."""
    return [finite_array(name, array, (6,)) for name, array in zip(
        _ARGUMENTS, (state.q, state.qd, q_before, *reference), strict=True)]
