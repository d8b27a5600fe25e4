"""Gains of the error equation e'' + Kd e' + Kp e = 0, refused unless it dies out."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.wording import number_of


class Gains(NamedTuple):
    """
    Position and velocity gain as matrices, checked by :func:`gains_from`.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import Gains
    >>> Gains(kp=100.0 * np.eye(6), kd=20.0 * np.eye(6)).kp.shape
    (6, 6)

    """

    kp: np.ndarray
    """Position gain, shape (6, 6): [1/s^2], or [N m/rad] in the modes without M."""
    kd: np.ndarray
    """Velocity gain, shape (6, 6): [1/s], or [N m s/rad] in the modes without M."""


def gains_from(kp: Sequence[float] | float, kd: Sequence[float] | float) -> Gains:
    """
    Return the gain matrices of 1, 6 or 36 numbers each.

    Kebria 2016, section V: KP = KD = 10 I, justified by Routh-Hurwitz.
    """
    gains = Gains(_matrix('kp', kp), _matrix('kd', kd))
    for name, matrix in zip(gains._fields, gains, strict=True):
        _check_definite(name, matrix)
    slowest = float(error_poles(gains).real.max())
    if slowest >= 0.0:
        raise InputError("kp, kd: e'' + Kd e' + Kp e = 0 has a pole with real part "
                         f"{slowest:.6g}; "
                         'all must be negative (Routh-Hurwitz): raise kd')
    return gains


def error_poles(gains: Gains) -> np.ndarray:
    """
    Return the twelve poles of e'' + Kd e' + Kp e = 0, the eigenvalues of its companion matrix.

    Returned: poles [1/s], in no order, (12,).
    """
    companion = np.zeros((12, 12))
    companion[:6, 6:] = np.eye(6)
    companion[6:, :6] = -gains.kp
    companion[6:, 6:] = -gains.kd
    return np.linalg.eigvals(companion)


def sampled_radius(gains: Gains, inertia: np.ndarray | None, period: float) -> float:
    """
    Return the spectral radius of the error equation sampled by semi-implicit Euler.

    d' = d - h W (Kd d + Kp e), e' = e + h d', with W = 1 where the law weighs the gains by M and
    W = 1/M where it does not.  Above one the held torque shakes the arm, however stable the
    continuous equation is.

    ``inertia`` (6, 6): M [kg m^2], for laws that do not weigh the gains by it; ``period``: control
    period h [s].  Returned: largest magnitude of an eigenvalue; below one the sampled loop is
    stable.
    """
    kp, kd = gains
    if inertia is not None:
        kp, kd = np.linalg.solve(inertia, kp), np.linalg.solve(inertia, kd)
    step = np.zeros((12, 12))
    step[6:, :6] = -period * kp
    step[6:, 6:] = np.eye(6) - period * kd
    step[:6] = np.hstack([np.eye(6), np.zeros((6, 6))]) + period * step[6:]
    return float(np.abs(np.linalg.eigvals(step)).max())


def _matrix(name: str, values: Sequence[float] | float) -> np.ndarray:
    try:
        numbers = np.array(values, dtype=float).ravel()
    except (TypeError, ValueError):
        raise InputError(f'{name} is {values!r}; give 1, 6 or 36 numbers') from None
    if not np.all(np.isfinite(numbers)):
        bad = numbers[~np.isfinite(numbers)][0]
        raise InputError(f'{name} holds {bad}; give finite numbers')
    if numbers.size == 1:
        return numbers[0] * np.eye(6)
    if numbers.size == 6:
        return np.diag(numbers)
    if numbers.size == 36:
        return numbers.reshape(6, 6)
    raise InputError(f'{name} has {number_of(numbers.size, "number")}; give 1, 6 (diagonal) or 36 '
                     '(row by row)')


def _check_definite(name: str, matrix: np.ndarray) -> None:
    scale = max(1.0, float(np.abs(matrix).max()))
    skewness = float(np.abs(matrix - matrix.T).max())
    if skewness > 1e-9 * scale:
        raise InputError(f'{name} differs from its transpose by {skewness:.6g}; '
                         'give a symmetric matrix')
    lowest = float(np.linalg.eigvalsh(matrix).min())
    if lowest <= 0.0:
        raise InputError(f'{name} has the eigenvalue {lowest:.6g}; all must be greater than zero '
                         '(Routh-Hurwitz)')


def definite_matrix(name: str, values: Sequence[float]) -> np.ndarray:
    """Return 1, 6 or 36 numbers as a symmetric positive definite matrix, shape (6, 6)."""
    matrix = _matrix(name, values)
    _check_definite(name, matrix)
    return matrix
