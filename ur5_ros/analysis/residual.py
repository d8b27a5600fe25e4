"""Model residual: how far the recorded motion is from the equations, as torque."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import PlantModel, predict
from ur5_ros.model.dynamics import inertia_matrix, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Rows that one pass takes, so that memory stays flat.
CHUNK = 16384

#: Speed below which a joint sticks [rad/s]; in the simulator it is rounding, 1e-16.
STICKING = 1e-12


class Residual(NamedTuple):
    """Defect of every recorded period; NaN where it cannot be told."""

    torque: np.ndarray
    """Residual [N m], shape (n - 1, 6)."""
    position: np.ndarray
    """Defect of q' = q + h qd' [rad], shape (n - 1, 6)."""


def residual(run: Run, plan: list[tuple[int, PlantModel]]) -> Residual:
    """
    Return the residual of every period.

    r_k = M(q_k)(qd_{k+1} - qd_k)/h + C qd_k + g + D qd_{k+1} + f(qd_{k+1}) - J^T w - effort_{k+1},
    D, f and w being the friction and the wrench of the scheme; with n physics steps a period the
    scheme is integrated n times under constant effort, and r_k = M(q_k)(qd_{k+1} -
    prediction)/(n h).  A joint at its stop is left out.

    Parameters
    ----------
    run : Run
        The recording; its exact states are used where they are known.
    plan : list of (int, PlantModel)
        The scheme in force from each row on, the first being row 0.

    Returns
    -------
    Residual
        Torque and position defects.

    """
    q, qd, effort = run.exact
    last = len(q) - 1
    whole = run.steps
    torque = np.full((last, 6), np.nan)
    position = torque.copy()
    ends = [first for first, _ in plan[1:]] + [last]
    for (first, scheme), end in zip(plan, ends, strict=True):
        for start in range(first, min(end, last), CHUNK):
            rows = np.arange(start, min(start + CHUNK, end, last))
            rows = rows[whole[rows]]
            if len(rows):
                torque[rows], position[rows] = _defects(
                    scheme, q[rows], qd[rows], effort[rows + 1], q[rows + 1], qd[rows + 1], run)
    return Residual(torque, position)


def _defects(scheme, q, qd, effort, q_next, qd_next, run):
    """Return torque and position defect of these periods, each of shape (n, 6)."""
    h, n = 1.0 / run.physics_rate, run.substeps
    angles = q + scheme.arm.angle_offset
    if n == 1:
        torque = inverse_dynamics(angles, qd, (qd_next - qd) / h, scheme.arm) - effort
        torque += scheme.viscous * qd_next - scheme.external(q)
        torque = _beyond_coulomb(torque, qd_next, scheme.coulomb)
        position = q_next - q - h * qd_next
    else:
        q_end, qd_end = predict(scheme, q, qd, effort, h, n)
        gap = (qd_next - qd_end) / (n * h)
        torque = np.einsum('nij,nj->ni', inertia_matrix(angles, scheme.arm), gap)
        position = q_next - q_end
    torque[at_stop(q_next, scheme.arm)] = np.nan  # the reaction of the stop is not recorded
    return torque, position


def at_stop(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """Tell which joints of positions ``q`` [rad], shape (..., 6), are at the end of their way."""
    return (q >= arm.limits.upper - 1e-9) | (q <= arm.limits.lower + 1e-9)


def _beyond_coulomb(torque: np.ndarray, qd_next: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Return what is left when Coulomb friction takes its share: all it can where it sticks."""
    sticking = np.abs(qd_next) <= STICKING
    return np.where(sticking, torque - np.clip(torque, -level, level),
                    torque + level * np.sign(qd_next))
