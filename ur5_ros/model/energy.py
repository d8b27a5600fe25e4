"""Energy of the arm: constant where nothing drives and nothing rubs."""

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

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import kinetic_energy, load_arm
    >>> q = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
    >>> energy = kinetic_energy(q, np.ones((2, 6)) * [[1.0], [2.0]], load_arm('ur5'))
    >>> bool(np.isclose(energy[1], 4.0 * energy[0]))
    True

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

    Examples
    --------
    >>> from ur5_ros import load_arm, potential_energy
    >>> stretched, upright = [0.0] * 6, [0.0, -1.5708, 0.0, -1.5708, 0.0, 0.0]
    >>> arm = load_arm('ur5')
    >>> bool(potential_energy(upright, arm) > potential_energy(stretched, arm))
    True

    """
    mass, com, _ = arm.bodies
    weight = np.zeros((6, 4, 4))  # m gamma^T (R c + p), linear in the frames
    weight[:, :3, :3] = np.einsum('l,i,lj->lij', mass, arm.gravity, com)
    weight[:, :3, 3] = np.outer(mass, arm.gravity)
    frames = link_transforms(q, arm)
    # a sum, not @: BLAS adds in another order for one state than for many
    return -(frames.reshape(*frames.shape[:-3], 96) * weight.ravel()).sum(axis=-1)
