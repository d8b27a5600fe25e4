"""
Kinematics of the arm: poses of its links and flange, Jacobian and its rate.

All functions broadcast over leading dimensions.  Angles are those of the arm record, q_model =
q_UR + ``arm.angle_offset``; poses stand in ``base``.  Frames are those of the standard DH
convention; frame 6 is ``tool0``.
"""

import numpy as np
from numpy import empty

from ur5_ros.model import calibration
from ur5_ros.model.kernels import kinematics as kernels
from ur5_ros.model.kernels.arguments import finite_array, state_function
from ur5_ros.model.parameters import ArmParameters

_POSE, _LINKS, _MATRIX = (4, 4), (24, 4), (6, 6)
_pose = state_function(kernels.pose, 'q')
_links = state_function(kernels.links, 'q')
_jacobian = state_function(kernels.jacobian, 'q')
_jacobian_rate = state_function(kernels.jacobian_rate, 'q', 'qd')


def forward_kinematics(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return the pose of the flange (``tool0``) in ``base``.

    Kebria 2016, eqs. (1), (2); the printed eq. (2) lacks the factor s5 in the d6 terms of px and
    py.

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 4, 4)
        Homogeneous transforms [m].

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import forward_kinematics, load_arm
    >>> forward_kinematics([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], load_arm('ur5'))[:3, 3].round(5)
    array([-0.81725, -0.19145, -0.00549])

    """
    if arm.calibration is not None:
        return _chain(q, arm)[..., 5, :, :]
    return _pose(q, arm.constants, empty(_POSE))


def link_transforms(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return the poses of the six link frames (standard DH) in ``base``.

    Kebria 2016, Table I and eq. (1).

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 4, 4)
        Homogeneous transforms [m] of frames 1 to 6.

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import link_transforms, load_arm
    >>> link_transforms([0.0, -1.5, 1.5, 0.0, 0.0, 0.0], load_arm('ur5')).shape
    (6, 4, 4)

    """
    if arm.calibration is not None:
        at_zero = _links(np.zeros(6), arm.constants, empty(_LINKS)).reshape(6, 4, 4)
        return _chain(q, arm) @ calibration.link_offsets(arm, at_zero)
    rows = _links(q, arm.constants, empty(_LINKS))
    return rows.reshape(*rows.shape[:-2], 6, 4, 4)


def jacobian(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return the geometric Jacobian of the flange in ``base``.

    Its determinant is a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234).

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 6)
        Rows 1 to 3: velocity of the origin of ``tool0`` [m/rad]; rows 4 to 6: angular velocity.

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import jacobian, load_arm
    >>> q, qd = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2]), np.full(6, 0.1)
    >>> twist = jacobian(q, load_arm('ur5')) @ qd
    >>> twist.shape
    (6,)

    """
    if arm.calibration is not None:
        return calibration.chain_jacobian(_chain(q, arm))
    return _jacobian(q, arm.constants, empty(_MATRIX))


def jacobian_rate(q: np.ndarray, qd: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return the time derivative of the Jacobian.

    Parameters
    ----------
    q, qd : array_like, shape (..., 6)
        Joint positions [rad] and velocities [rad/s].
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 6)
        dJ/dt, rows as in :func:`jacobian`.

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import jacobian_rate, load_arm
    >>> q, qd = [0.3, -1.2, 1.5, -1.9, -1.4, 0.2], [0.1] * 6
    >>> jacobian_rate(q, qd, load_arm('ur5')).shape
    (6, 6)

    """
    if arm.calibration is not None:
        return calibration.chain_jacobian_rate(_chain(q, arm), finite_array('qd', qd, (6,)))
    return _jacobian_rate(q, qd, arm.constants, empty(_MATRIX))


def _chain(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """Return the frames of a calibrated arm, shape (..., 6, 4, 4)."""
    assert arm.calibration is not None
    return calibration.chain_frames(finite_array('q', q, (6,)), arm.calibration)


def singularity_factors(
    q: np.ndarray, arm: ArmParameters,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return the three factors of det J; where one is zero, the arm is singular.

    det J = a2 a3 sin q3 sin q5 X5.

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        The arm.

    Returns
    -------
    sin_q5, sin_q3 : numpy.ndarray, shape (...)
        Wrist (axes 4 and 6 parallel) and elbow (outstretched or folded).
    x5 : numpy.ndarray, shape (...)
        Shoulder: a2 c2 + a3 c23 + d5 s234 [m], how far outwards the origin of frame 5 lies from
        axis 1; its sign is negative for left, positive for right.

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import jacobian, load_arm, singularity_factors
    >>> arm, q = load_arm('ur5'), [0.3, -1.2, 1.5, -1.9, -1.4, 0.2]
    >>> product = arm.a[1] * arm.a[2] * np.prod(singularity_factors(q, arm))
    >>> bool(np.isclose(np.linalg.det(jacobian(q, arm)), product))
    True

    """
    q = finite_array('q', q, (6,))
    q23 = q[..., 1] + q[..., 2]
    x5 = (arm.a[1] * np.cos(q[..., 1]) + arm.a[2] * np.cos(q23)
          + arm.d[4] * np.sin(q23 + q[..., 3]))
    return np.sin(q[..., 4]), np.sin(q[..., 2]), x5
