r"""
Dynamics of the arm: :math:`M(q)\ddot q + C(q, \dot q)\dot q + g(q) = \tau` (eq. 6).

All functions broadcast over leading dimensions.  Angles are those of the arm record, q_model =
q_UR + ``arm.angle_offset``.
"""

import numpy as np
from numpy import empty

from ur5_ros.model.kernels.arguments import state_function
from ur5_ros.model.kernels.dynamics import gravity, inertia, inverse, terms
from ur5_ros.model.kernels.forward_dynamics import forward
from ur5_ros.model.parameters import ArmParameters

_MATRIX = (6, 6)
_inertia = state_function(inertia, 'q')
_gravity = state_function(gravity, 'q')
_terms = state_function(terms, 'q', 'qd', outputs=3)
_inverse = state_function(inverse, 'q', 'qd', 'qdd')
_forward = state_function(forward, 'q', 'qd', 'tau')


def inertia_matrix(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    r"""
    Return the inertia matrix of the arm, rotors on its diagonal.

    Kebria 2016, eq. (8): :math:`M = \sum_i m_i J_{v_i}^T J_{v_i} + J_{\omega_i}^T R_i I_i R_i^T
    J_{\omega_i}` with the velocity Jacobian of the centre of mass, plus the reflected rotor
    inertia (armature).

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 6)
        Symmetric and positive definite [kg m^2].

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import inertia_matrix, load_arm
    >>> M = inertia_matrix([0.3, -1.2, 1.5, -1.9, -1.4, 0.2], load_arm('ur5'))
    >>> bool(np.allclose(M, M.T)), bool(np.linalg.eigvalsh(M).min() > 0.0)
    (True, True)

    """
    return _inertia(q, arm.constants, empty(_MATRIX))


def coriolis_matrix(q: np.ndarray, qd: np.ndarray, arm: ArmParameters) -> np.ndarray:
    r"""
    Return the Coriolis and centrifugal matrix from Christoffel symbols.

    Kebria 2016, eq. (9): :math:`C_{ij} = \frac12\sum_k(\partial_k M_{ij} + \partial_j M_{ik} -
    \partial_i M_{jk})\dot q_k`, so that :math:`\dot M - 2C` is skew.

    Parameters
    ----------
    q, qd : array_like, shape (..., 6)
        Joint positions [rad] and velocities [rad/s].
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 6)
        C [N m s/rad].

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import coriolis_matrix, load_arm
    >>> q, qd = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2]), np.full(6, 0.5)
    >>> (coriolis_matrix(q, qd, load_arm('ur5')) @ qd).shape
    (6,)

    """
    return dynamics_terms(q, qd, arm)[1]


def gravity_torque(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    r"""
    Return the joint torque that holds the arm still against gravity.

    Kebria 2016, eq. (10): :math:`g(q) = \partial P / \partial q`.

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        Masses, centres of mass and gravity, in any direction.

    Returns
    -------
    numpy.ndarray, shape (..., 6)
        Holding torque [N m], positive along each joint axis.

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import gravity_torque, load_arm
    >>> g = gravity_torque([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], load_arm('ur5'))
    >>> abs(g).argmax()  # the shoulder carries the stretched arm
    np.int64(1)

    """
    return _gravity(q, arm.constants, empty(6))


def dynamics_terms(
    q: np.ndarray, qd: np.ndarray, arm: ArmParameters,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return M, C and g (eqs. 8 to 10) from one pass over the arm.

    Parameters
    ----------
    q, qd : array_like, shape (..., 6)
        Joint positions [rad] and velocities [rad/s].
    arm : ArmParameters
        The arm.

    Returns
    -------
    tuple of numpy.ndarray, shapes (..., 6, 6), (..., 6, 6), (..., 6)
        Inertia matrix [kg m^2], Coriolis matrix [N m s/rad], gravity torque [N m].

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import dynamics_terms, inverse_dynamics, load_arm
    >>> arm = load_arm('ur5')
    >>> q, qd, qdd = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2]), np.full(6, 0.5), np.ones(6)
    >>> M, C, g = dynamics_terms(q, qd, arm)
    >>> bool(np.allclose(M @ qdd + C @ qd + g, inverse_dynamics(q, qd, qdd, arm)))
    True

    """
    return _terms(q, qd, arm.constants, empty(_MATRIX), empty(_MATRIX), empty(6))


def inverse_dynamics(
    q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, arm: ArmParameters,
) -> np.ndarray:
    """
    Return the joint torque of a motion: M qdd + C qd + g.

    Kebria 2016, eq. (6).

    Parameters
    ----------
    q, qd, qdd : array_like, shape (..., 6)
        Joint positions [rad], velocities [rad/s] and accelerations [rad/s^2].
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6)
        Joint torque [N m].

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import inverse_dynamics, load_arm
    >>> q, qd, qdd = [0.3, -1.2, 1.5, -1.9, -1.4, 0.2], [0.0] * 6, [1.0] * 6
    >>> inverse_dynamics(q, qd, qdd, load_arm('ur5')).shape
    (6,)

    """
    return _inverse(q, qd, qdd, arm.constants, empty(6))


def forward_dynamics(
    q: np.ndarray, qd: np.ndarray, tau: np.ndarray, arm: ArmParameters,
) -> np.ndarray:
    r"""
    Return the joint acceleration under a torque.

    Kebria 2016, eq. (7): :math:`\ddot q = M^{-1}(\tau - C\dot q - g)`; the paper calls it inverse
    dynamics, it is forward dynamics.  M is never singular, at no configuration.

    Parameters
    ----------
    q, qd, tau : array_like, shape (..., 6)
        Joint positions [rad], velocities [rad/s] and torques [N m].
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6)
        Joint acceleration [rad/s^2].

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import forward_dynamics, gravity_torque, load_arm
    >>> arm, q = load_arm('ur5'), np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
    >>> qdd = forward_dynamics(q, np.zeros(6), gravity_torque(q, arm), arm)
    >>> bool(np.abs(qdd).max() < 1e-12)  # the arm stays where it is
    True

    """
    return _forward(q, qd, tau, arm.constants, empty(6))
