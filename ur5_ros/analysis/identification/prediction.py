"""How well an identified arm predicts the torque of a recording."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.identification.base_parameters import BaseParameters
from ur5_ros.analysis.identification.fitting import Solution
from ur5_ros.analysis.identification.rows import Rows, of_three


class Prediction(NamedTuple):
    """Torque of a recording and how well it is predicted, over windows of 0.3 s; shapes (6,)."""

    run: str
    torque_rms: np.ndarray
    """Torque, root mean square [N m]."""
    error_rms: np.ndarray
    """Error of the physical arm with friction [N m]; NaN where a joint never slides."""
    error_max: np.ndarray
    """Largest error [N m]."""
    fit_rms: np.ndarray
    """Error of the least squares, which need not be physical [N m]."""
    series: dict[str, np.ndarray]
    """``time`` (n,), ``speed``, ``torque``, ``predicted``, (n, 6), ``error`` (n - 2, 6)."""

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON, without the series."""
        return {name: value if isinstance(value, str) else value.tolist()
                for name, value in self._asdict().items() if name != 'series'}


def predict(rows: Rows, base: BaseParameters, found: Solution, run: str) -> Prediction:
    """Return how well the arm and the fit predict the torque of windows, three at a time."""
    fit = found.best
    friction = fit.friction_torque(rows.friction)
    with_friction = np.isin(np.arange(6), [joint for joint, _ in fit.friction])
    predicted, fitted = rows.inertial @ found.x, rows.inertial[..., base.columns] @ fit.base
    unknown = np.where(rows.sliding | ~with_friction, 0.0, np.nan)
    wrong, wrong_fit = (of_three(rows, rows.effort - torque - friction + unknown)
                        for torque in (predicted, fitted))
    known = np.isfinite(wrong)
    return Prediction(
        run, np.sqrt(np.mean(rows.effort**2, axis=0)), _rms(wrong),
        np.where(known.any(axis=0), np.abs(np.where(known, wrong, 0.0)).max(axis=0), np.nan),
        _rms(wrong_fit), {'time': rows.time, 'speed': rows.speed, 'torque': rows.effort,
                          'predicted': predicted + friction + unknown, 'error': wrong})


def without_torque(rows: Rows, run: str) -> Prediction:
    """Return a prediction without errors, of windows that have no torque to compare with."""
    unknown, nothing = np.full(6, np.nan), np.full_like(rows.effort, np.nan)
    return Prediction(run, unknown, unknown, unknown, unknown, {
        'time': rows.time, 'speed': rows.speed, 'torque': nothing, 'predicted': rows.effort,
        'error': nothing[2:]})


def _rms(values: np.ndarray) -> np.ndarray:
    """Return the root mean square of each column's numbers; NaN where it has none."""
    known = np.isfinite(values)
    square = np.sum(np.where(known, values, 0.0)**2, axis=0)
    count = known.sum(axis=0)
    return np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)
