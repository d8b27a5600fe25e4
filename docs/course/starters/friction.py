"""Joint friction: fill in the functions."""

import numpy as np


def friction_torque(qd, viscous, coulomb):
    """Return what the motors need against friction [N m], shape (6,)."""
    return np.zeros(6)


def fit_friction(speeds, torques):
    """Return viscous and Coulomb coefficients, shape (2, 6), from speeds and torques (n, 6)."""
    return np.zeros((2, 6))
