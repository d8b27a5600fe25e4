"""Base parameters: the combinations of inertias and rotors that motion and torque determine."""

from typing import NamedTuple

import numpy as np

from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import LINK_PARAMETERS, dynamics_regressor, inertial_parameters

#: Names of the 66 parameters: ten a link, then the rotors.
NAMES = tuple(f'{name}{i}' for i in range(1, 7) for name in LINK_PARAMETERS) + tuple(
    f'rotor{i}' for i in range(1, 7))


class BaseParameters(NamedTuple):
    """The independent combinations, and their columns of the regressor."""

    combination: np.ndarray
    """Base parameters = combination @ parameters, shape (b, 66)."""
    columns: np.ndarray
    """Which columns of the regressor are independent, shape (b,)."""

    @property
    def names(self) -> list[str]:
        """Return the name of each base parameter: that of its column."""
        return [NAMES[column] for column in self.columns]


def base_of(arm: ArmParameters, states: int = 500) -> BaseParameters:
    """
    Return which combinations of the 66 parameters motion and torque determine.

    Dependent columns show as zeros on the diagonal of the QR decomposition over spread states
    (Gautier 1991) and are folded into the columns before them.

    ``arm``: geometry and gravity; masses do not enter.
    """
    random = np.random.default_rng(1)
    q, qd, qdd = random.uniform(-1.0, 1.0, (3, states, 6)) * np.array([np.pi, 2.0, 5.0])[
        :, None, None]
    w = inertial_columns(q, qd, qdd, arm).reshape(-1, 66)
    size = np.linalg.norm(w, axis=0)
    size[size == 0.0] = 1.0
    w = w / size
    diagonal = np.abs(np.diag(np.linalg.qr(w, mode='r')))
    columns, others = np.flatnonzero(diagonal > 1e-8), np.flatnonzero(diagonal <= 1e-8)
    folded, *_ = np.linalg.lstsq(w[:, columns], w[:, others], rcond=None)
    combination = np.zeros((len(columns), 66))
    combination[np.arange(len(columns)), columns] = 1.0
    combination[:, others] = folded * size[others] / size[columns][:, None]
    combination[np.abs(combination) < 1e-10] = 0.0
    return BaseParameters(combination, columns)


def inertial_columns(q, qd, qdd, arm: ArmParameters) -> np.ndarray:
    """Return the regressor of links and rotors, shape (..., 6, 66); angles of the model."""
    return np.concatenate([dynamics_regressor(q, qd, qdd, arm), qdd[..., None] * np.eye(6)],
                          axis=-1)


def all_parameters(arm: ArmParameters) -> np.ndarray:
    """Return the 66 parameters of an arm, payload merged into link 6."""
    return np.concatenate([inertial_parameters(arm), arm.armature])


def typical_sizes(arm: ArmParameters) -> np.ndarray:
    """Return how large each of the 66 parameters is for bodies like those of the arm."""
    reach = np.abs(arm.a).max() + np.abs(arm.d).max()
    mass = arm.bodies[0][:, None]
    link = mass * np.array([1.0, *3 * [0.5 * reach], *6 * [(0.5 * reach)**2]])
    return np.concatenate([link.ravel(), np.full(6, link[:, 4:].max())])
