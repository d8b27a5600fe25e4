"""Exercise: base parameters by least squares, with honest standard errors."""

from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.course.exercise import Exercise, Line, answer, compare
from ur5_ros.model.regressor import base_parameters, dynamics_regressor, inertial_parameters

ARM = load_arm('ur5')
_BASE = base_parameters(ARM)
_TRUE = _BASE.combination @ inertial_parameters(ARM)
_NOISE = 0.5


def data(random: np.random.Generator, states: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Return Y (6 n, b) and torques with noise (6 n,) [N m]."""
    q = random.uniform(-np.pi, np.pi, (states, 6))
    qd, qdd = random.uniform(-2.0, 2.0, (states, 6)), random.uniform(-5.0, 5.0, (states, 6))
    y = dynamics_regressor(q, qd, qdd, ARM)[..., _BASE.columns].reshape(-1, len(_TRUE))
    return y, y @ _TRUE + random.normal(0.0, _NOISE, len(y))


def _fit(y: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    estimate, *_ = np.linalg.lstsq(y, tau, rcond=None)
    left = tau - y @ estimate
    variance = left @ left / (len(tau) - len(estimate)) * np.diag(np.linalg.inv(y.T @ y))
    return estimate, np.sqrt(variance)


def _estimate(module: Any, random: np.random.Generator) -> tuple[str, str]:
    y, tau = data(random)
    size = (len(_TRUE),)
    right = _fit(y, tau)[0]
    return compare('the parameters', answer(module, 'estimate', y, tau, shape=size), right, {
        "the torque's sign": -right}, 1e-5)


def _errors(module: Any, random: np.random.Generator) -> tuple[str, str]:
    y, tau = data(random)
    size = (len(_TRUE),)
    right = _fit(y, tau)[1]
    degrees = len(tau) - len(right)
    got = answer(module, 'standard_errors', y, tau, shape=size)
    return compare('the standard errors relative to the right ones', got / right,
                   np.ones_like(right), {
        'variances instead of standard errors': right,
        'the noise is taken for 1': np.sqrt(np.diag(np.linalg.inv(y.T @ y))) / right,
        'no degrees of freedom taken off': np.full_like(right, np.sqrt(degrees / len(tau))),
    }, 1e-5)


def _prediction(module: Any, random: np.random.Generator) -> tuple[str, str]:
    y, tau = data(random)
    got = answer(module, 'estimate', y, tau, shape=(len(_TRUE),))
    new = data(random)[0]
    rms = float(np.sqrt(np.mean((new @ (got - _TRUE))**2)))
    allowed = 2.0 * _NOISE * np.sqrt(len(_TRUE) / len(tau))
    return ('', '') if rms <= allowed else (
        f'on new motion the torque is wrong by {rms:.3g} N m; at most {allowed:.3g}', '')


EXERCISE = Exercise('identification', (
    Line('parameters', 4.0, _estimate), Line('standard errors', 3.0, _errors),
    Line('prediction', 3.0, _prediction)))
