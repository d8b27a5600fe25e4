r"""
The dynamics as linear in the inertial parameters: :math:`\tau = Y(q, \dot q, \ddot q)\,\pi`.

Per link :math:`\pi` holds m, m c (3), and the tensor about the origin of the link frame as xx, xy,
yy, xz, yz, zz (the order of Pinocchio and of most identification software), links one after the
other.  Rotor inertia is kept apart: it adds the columns diag(qdd).
"""

import math
from typing import NamedTuple

import numpy as np

from ur5_ros.model.kernels import regressor as kernels
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.kinematics import link_transforms
from ur5_ros.model.parameters import ArmParameters

#: Names of the parameters of one link.
LINK_PARAMETERS = ('m', 'mcx', 'mcy', 'mcz', 'Ixx', 'Ixy', 'Iyy', 'Ixz', 'Iyz', 'Izz')


class BaseParameters(NamedTuple):
    """Combinations of the 60 inertial parameters that motion and torque determine."""

    columns: np.ndarray
    """Columns of Y that are independent, shape (b,)."""
    combination: np.ndarray
    """Base parameters = combination @ pi, shape (b, 60); Y[..., columns] @ them is the torque."""
    condition: float
    """Condition number of Y[..., columns], columns scaled, over the states used."""


def inertial_parameters(arm: ArmParameters) -> np.ndarray:
    """
    Return pi of an arm, payload merged into link 6.

    Returned: in kg, kg m and kg m^2, ten numbers a link, (60,).
    """
    return link_parameters(*arm.bodies)


def link_parameters(mass: np.ndarray, com: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """
    Return pi of bodies.

    ``mass`` (6,): masses [kg]; ``com`` (6, 3): centres of mass in the link frames [m]; ``inertia``
    (6, 3, 3): tensors about the centres of mass [kg m^2].  Returned: in kg, kg m and kg m^2, ten
    numbers a link, (60,).
    """
    numbers = []
    for m, c, tensor in zip(mass, com, inertia, strict=True):
        about_origin = tensor + m * (np.dot(c, c) * np.eye(3) - np.outer(c, c))
        numbers += [m, *(m * c), *about_origin[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    return np.array(numbers)


def dynamics_regressor(
    q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, arm: ArmParameters,
) -> np.ndarray:
    r"""
    Return the matrix Y with Y pi = inverse dynamics, rotor inertia left out.

    Newton's and Euler's equations of each link about the origin of its frame are linear in
    (m, m c, I); the transposed Jacobian of that frame turns them into joint torques.  This is a
    derivation of its own and a witness of :func:`~ur5_ros.model.dynamics.inverse_dynamics`.

    Parameters
    ----------
    q, qd, qdd : array_like, shape (..., 6)
        Joint positions [rad], velocities [rad/s] and accelerations [rad/s^2].
    arm : ArmParameters
        Geometry and gravity; masses do not enter.

    Returns
    -------
    numpy.ndarray, shape (..., 6, 60)
        Joint torque for each unit of the 60 parameters.

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    Examples
    --------
    >>> from ur5_ros import dynamics_regressor, load_arm
    >>> q, qd, qdd = [0.3, -1.2, 1.5, -1.9, -1.4, 0.2], [0.5] * 6, [1.0] * 6
    >>> dynamics_regressor(q, qd, qdd, load_arm('ur5')).shape
    (6, 60)

    """
    q, qd, qdd = (finite_array(name, x, (6,)) for name, x in
                  (('q', q), ('qd', qd), ('qdd', qdd)))
    lead = np.broadcast_shapes(q.shape, qd.shape, qdd.shape)[:-1]
    frames = _of_shape(link_transforms(q, arm), (*lead, 6, 4, 4))  # one pose serves all speeds
    y = np.empty((*lead, 6, 60))
    kernels.regressor.run(
        math.prod(lead), [frames.reshape(-1, 4), *(_of_shape(each, (*lead, 6)).reshape(-1)
                                                   for each in (qd, qdd))],
        [np.array(arm.gravity, dtype=float)], [y.reshape(-1, 60)])
    return y


def base_parameters(arm: ArmParameters, states: int = 400) -> BaseParameters:
    """
    Return which combinations of the inertial parameters can be identified.

    Dependent columns of Y over well spread states are found from the zeros on the diagonal of its
    QR decomposition (Gautier 1991) and folded into the columns before them.

    ``arm``: geometry and gravity; masses do not enter.
    """
    # multiples of irrational numbers modulo one: spread evenly, and the same every time
    spread = np.modf(np.outer(np.arange(1, states + 1), np.sqrt([
        2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61])))[0] * 2.0 - 1.0
    y = dynamics_regressor(np.pi * spread[:, :6], 2.0 * spread[:, 6:12], 5.0 * spread[:, 12:],
                           arm).reshape(-1, 60)
    size = np.linalg.norm(y, axis=0)
    y = y / np.where(size > 0.0, size, 1.0)
    diagonal = np.abs(np.diag(np.linalg.qr(y, mode='r')))
    columns = np.flatnonzero(diagonal > 1e-9)
    others = np.flatnonzero(diagonal <= 1e-9)
    folded, *_ = np.linalg.lstsq(y[:, columns], y[:, others], rcond=None)
    folded *= np.where(size > 0.0, size, 1.0)[others] / size[columns][:, None]
    folded[np.abs(folded) < 1e-9] = 0.0
    combination = np.zeros((columns.size, 60))
    combination[np.arange(columns.size), columns] = 1.0
    combination[:, others] = folded
    return BaseParameters(columns, combination, float(np.linalg.cond(y[:, columns])))


def _of_shape(array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return a contiguous array of a shape, its rows repeated where they have to be."""
    return np.ascontiguousarray(array if array.shape == shape else np.broadcast_to(array, shape))
