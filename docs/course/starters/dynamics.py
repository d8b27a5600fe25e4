"""Dynamics of the UR5: fill in the functions; SI units."""

import numpy as np

from ur5_ros import load_arm

ARM = load_arm('ur5')  # ARM.mass, ARM.com, ARM.inertia (about the centres), ARM.gravity


def gravity_torque(q):
    """Return g(q), the torque that holds the arm still, shape (6,)."""
    return np.zeros(6)


def inertia_matrix(q):
    """Return M(q), shape (6, 6)."""
    return np.eye(6)


def coriolis_matrix(q, qd):
    """Return C(q, qd) from Christoffel symbols, shape (6, 6)."""
    return np.zeros((6, 6))
