"""A load at the tool, from the torque or the current that it takes."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.identification.least_squares import blocks_of, least_squares
from ur5_ros.analysis.identification.motors import Motors
from ur5_ros.analysis.identification.rows import Rows
from ur5_ros.analysis.result import plain

#: A mass that is less certain than this is not determined [kg].
LARGEST_ERROR = 0.5

#: How well the torque of an arm without a load is known, as a share of its largest joint's:
#: gravity alone differs between makers by a thousandth.
MODEL_ERROR = 1e-3

#: Standard errors from which on a mass is there, and has a centre.
SIGNIFICANT = 3.0


class PayloadEstimate(NamedTuple):
    """What is at the tool beyond what the arm has."""

    run: str
    quantity: str
    """What it was found from: ``torque`` or ``current``."""
    mass: float
    """[kg]; NaN where the motion does not determine it."""
    mass_error: float
    com: np.ndarray
    """Centre of mass in ``tool0`` [m], shape (3,); NaN where not determined."""
    com_error: np.ndarray

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return plain({'run': self.run, 'from': self.quantity, 'mass': self.mass,
                      'mass_error': self.mass_error, 'com': self.com.tolist(),
                      'com_error': self.com_error.tolist()})

    def sentence(self) -> str:
        """Return the outcome in words."""
        if not np.isfinite(self.mass):
            return (f'{self.run}: this motion does not determine a load at the tool; turn the '
                    'wrists to several poses')
        words = (f'load at the tool in {self.run}, from {self.quantity}: {self.mass:.4g} +- '
                 f'{self.mass_error:.1g} kg')
        if np.isfinite(self.com).all():
            words += (', centre of mass ['
                      + ', '.join(f'{c:.3g} +- {e:.1g}' for c, e in
                                  zip(self.com, self.com_error, strict=True)) + '] m in tool0')
        return words


def payload_from(
    rows: Rows, expected: np.ndarray, features: np.ndarray, motors: Motors | None, run: str,
) -> PayloadEstimate:
    """
    Return the load that explains what the arm alone does not.

    ``expected`` (n, 6): torque of the arm without it, friction included where the torque has it [N
    m]; ``features`` (n, 6, 12): features of friction; ``motors``: drives and friction of the arm
    without the load; the current is then used.
    """
    load = rows.inertial[:, :, 50:60]
    if motors is None:
        missing, known = rows.effort - expected, np.isfinite(rows.effort)
        quantity = 'torque'
    else:
        missing, known = _missing_current(rows, features, motors)
        quantity = 'current'
    nothing = np.full(3, np.nan)
    if not known.any():
        return PayloadEstimate(run, quantity, np.nan, np.nan, nothing, nothing)
    block = blocks_of(rows.time, rows.run)
    largest = np.sqrt(np.max(np.mean(np.nan_to_num(expected)**2, axis=0)))
    fit = least_squares(load, np.nan_to_num(missing), known, block, MODEL_ERROR * largest)
    mass = float(fit.value[0])
    error = float(np.hypot(fit.error[0], mass * _drive_error(load, fit.weight, motors)))
    if not fit.determined[0] or error > LARGEST_ERROR:
        return PayloadEstimate(run, quantity, np.nan, np.nan, nothing, nothing)
    com, com_error = nothing, nothing
    if fit.determined[1:4].all() and abs(mass) > SIGNIFICANT * error:
        com = fit.value[1:4] / mass
        slope = np.column_stack([-com / mass, np.eye(3) / mass])
        com_error = np.sqrt(np.diag(slope @ fit.covariance[:4, :4] @ slope.T))
    return PayloadEstimate(run, quantity, mass, error, com, com_error)


def _drive_error(load: np.ndarray, weight: np.ndarray, motors: Motors | None) -> float:
    """Return the relative error of the drives, each weighed by its part in the mass."""
    if motors is None:
        return 0.0
    share = np.sum((weight * load[:, :, 0])**2, axis=0)
    relative = np.nan_to_num(motors.drive_error / motors.drive)
    return float(np.sum(share * np.abs(relative)) / max(float(share.sum()), 1e-300))


def _missing_current(rows: Rows, features, motors: Motors) -> tuple[np.ndarray, np.ndarray]:
    """Return drive x current - torque - friction [N m], and where it is known, (n, 6) each."""
    missing = np.full_like(rows.effort, np.nan)
    for i, model in enumerate(motors.model):
        if model is not None:
            x = np.column_stack([rows.effort[:, i], features[:, i]])
            missing[:, i] = (rows.current[:, i] - x @ model) / model[0]
    return missing, np.isfinite(missing) & rows.sliding
