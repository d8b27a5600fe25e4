"""Weighted least squares over windows, with standard errors that hold for dependent residuals."""

from typing import NamedTuple

import numpy as np

#: Passes that find the weights of joints and of outlying windows.
PASSES = 6

#: A residual beyond so many of its joint's own size loses weight (Huber 1964).
OUTLIER_RATIO = 4.0

#: Length of the blocks left out for the standard errors [s], least and most of them.
BLOCK, LEAST_BLOCKS, MOST_BLOCKS = 1.0, 10, 80

#: Directions of the scaled regressor weaker than this carry rounding alone.
RANK = 1e-6

#: Residuals under this share of the torque are rounding: nothing is weighed by them.
ROUNDING = 1e-9


class Estimate(NamedTuple):
    """Parameters of a linear model of p columns."""

    value: np.ndarray
    """Estimates, shape (p,); of columns that are not determined the one of least size."""
    covariance: np.ndarray
    """Of the estimates, shape (p, p)."""
    determined: np.ndarray
    """Whether the data determine each parameter, shape (p,)."""
    condition: float
    """Condition number of the scaled regressor, determined directions only."""
    factor: np.ndarray
    """Square root of the information: covariance = inverse(factor.T @ factor), shape (r, p)."""
    weight: np.ndarray
    """Weight of each window and joint [1/(N m)], shape (n, 6)."""
    residual: np.ndarray
    """Torque - model [N m], shape (n, 6)."""

    @property
    def error(self) -> np.ndarray:
        """Return the standard errors, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))


def least_squares(
    x: np.ndarray, y: np.ndarray, known: np.ndarray, block: np.ndarray, floor: float = 0.0,
) -> Estimate:
    """
    Fit y = x @ value, each joint weighed by what it leaves unexplained.

    Outlying windows lose weight by Huber's rule.  The covariance is that of the delete-a-block
    jackknife (Efron 1982, ch. 4) with half the products of next neighbours: residuals that depend
    on each other, and noise whose size changes along the run, are accounted for.

    ``x`` (n, 6, p): regressor; ``y`` (n, 6): what it is to explain; ``known`` (n, 6): which of
    them count; ``block`` (n,): number of the block that each window belongs to; ``floor``:
    residual under which no joint weighs more [N m]: what the model itself is not known to.
    """
    scale = np.sqrt(np.mean(y**2)) + 1e-12
    weight = known / np.sqrt(_mean_square(y, known) + 1e-6 * scale**2 + floor**2)
    for _ in range(PASSES - 1):
        residual = y - x @ _quick(x, y, weight)
        spread = np.sqrt(_mean_square(residual, known))
        if spread.max() < ROUNDING * scale:
            break
        spread = np.maximum(spread, max(1e-6 * scale, floor))
        surplus = np.maximum(np.abs(residual) / (OUTLIER_RATIO * spread), 1.0)
        weight = known / (spread * np.sqrt(surplus))
    value, basis, strength, size = _solve(x, y, weight)
    residual = y - x @ value
    covariance, inflation = _jackknife(x, residual, weight, block, basis, strength, size)
    lost = 1.0 - np.sum(basis**2, axis=1)
    return Estimate(value, covariance, (lost < 1e-3) & (np.linalg.norm(basis, axis=1) > 0.0),
                    float(strength[0] / strength[-1]),
                    strength[:, None] * basis.T * size / np.sqrt(inflation), weight, residual)


def blocks_of(time: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Return the number of the jackknife's block of each window, runs apart, from time [s]."""
    whole = sum(np.ptp(time[run == each]) for each in np.unique(run))
    length = np.clip(BLOCK, whole / MOST_BLOCKS, max(whole / LEAST_BLOCKS, 1e-9))
    return np.unique((time // length).astype(int) + 1_000_000 * run, return_inverse=True)[1]


def _mean_square(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    return np.sum(known * values**2, axis=0) / np.maximum(known.sum(axis=0), 1)


def _quick(x: np.ndarray, y: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the value by the normal equations: good enough for weights."""
    rows = (x * weight[..., None]).reshape(-1, x.shape[-1])
    gram = rows.T @ rows
    size = np.sqrt(np.diag(gram))
    size[size == 0.0] = 1.0
    along = rows.T @ (y * weight).ravel() / size
    return np.linalg.pinv(gram / np.outer(size, size), RANK**2, hermitian=True) @ along / size


def _solve(x: np.ndarray, y: np.ndarray, weight: np.ndarray):
    """Return value, right singular vectors (p, r), singular values and sizes of the columns."""
    rows = (x * weight[..., None]).reshape(-1, x.shape[-1])
    size = np.linalg.norm(rows, axis=0)
    size[size == 0.0] = 1.0
    tall, square = np.linalg.qr(rows / size)
    left, strength, right = np.linalg.svd(square, full_matrices=False)
    keep = strength > RANK * strength[0]
    basis, strength = right[keep].T, strength[keep]
    along = left[:, keep].T @ (tall.T @ (y * weight).ravel())
    return basis @ (along / strength) / size, basis, strength, size


def _jackknife(x, residual, weight, block, basis, strength, size):
    """Return the covariance, and by how much it exceeds that of independent residuals."""
    whiten = (basis / strength) / size[:, None]  # (p, r): columns to an orthonormal regressor
    u = (x * weight[..., None]) @ whiten
    left = residual * weight
    count, r = int(block.max()) + 1, u.shape[-1]
    moved = np.zeros((count, r))
    for each in range(count):
        part = u[block == each].reshape(-1, r)
        out = part.T @ left[block == each].ravel()
        moved[each] = np.linalg.lstsq(np.eye(r) - part.T @ part, out, rcond=1e-10)[0]
    # Bartlett's half weight for next neighbours: noise of differences cancels between them.
    beside = moved[1:].T @ moved[:-1]
    inner = (moved.T @ moved + 0.5 * (beside + beside.T)) * (count - 1) / count
    inflation = max(float(np.median(np.diag(inner))), 1e-300)
    return whiten @ inner @ whiten.T, inflation
