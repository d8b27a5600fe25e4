"""Energy of the arm: what the equations of motion keep when nothing drives and nothing rubs."""

import numpy as np

from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.kernels.arguments import finite_array
from ur5_ros.model.kinematics import link_transforms
from ur5_ros.model.parameters import ArmParameters


def kinetic_energy(q: np.ndarray, qd: np.ndarray, arm: ArmParameters) -> np.ndarray:
    r"""
    Return the kinetic energy :math:`\frac12 \dot q^T M(q) \dot q`, rotors included.

    Parameters
    ----------
    q, qd : array_like, shape (..., 6)
        Joint positions [rad] and velocities [rad/s].
    arm : ArmParameters
        The arm.

    Returns
    -------
    numpy.ndarray, shape (...)
        Energy [J].

    Raises
    ------
    InputError
        If an argument has another shape or holds a number that is not finite.

    """
    qd = finite_array('qd', qd, (6,))
    return 0.5 * np.einsum('...i,...ij,...j->...', qd, inertia_matrix(q, arm), qd)


def potential_energy(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    r"""
    Return the potential energy of links and payload, zero where all mass lies in the base origin.

    Kebria 2016, at eq. (10): :math:`P = -\sum_i m_i \gamma^T c_i`, so up is positive.

    Parameters
    ----------
    q : array_like, shape (..., 6)
        Joint positions [rad], base to wrist.
    arm : ArmParameters
        Masses, centres of mass, gravity.

    Returns
    -------
    numpy.ndarray, shape (...)
        Energy [J].

    Raises
    ------
    InputError
        If ``q`` has another shape or holds a number that is not finite.

    """
    mass, com, _ = arm.bodies
    weight = np.zeros((6, 4, 4))  # m gamma^T (R c + p), linear in the frames
    weight[:, :3, :3] = np.einsum('l,i,lj->lij', mass, arm.gravity, com)
    weight[:, :3, 3] = np.outer(mass, arm.gravity)
    frames = link_transforms(q, arm)
    # a sum, not @: BLAS adds in another order for one state than for many
    return -(frames.reshape(*frames.shape[:-3], 96) * weight.ravel()).sum(axis=-1)
