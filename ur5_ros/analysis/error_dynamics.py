"""Error dynamics: the recorded e(t) against e'' + Kd e' + Kp e = 0, sampled and continuous."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.series import Run

#: Samples that one matrix product takes.
BLOCK = 16


class ErrorDynamics(NamedTuple):
    """The tracking error and what theory makes of it."""

    error: np.ndarray
    """q - q* [rad], shape (n, 6); NaN where no reference is recorded."""
    rate: np.ndarray
    """qd - qd* [rad/s], shape (n, 6)."""
    step: np.ndarray
    """Defect of the sampled equation over one period [rad, rad/s], shape (n - 1, 12)."""
    sampled: np.ndarray
    """e predicted by the sampled equation from the start of its stretch [rad], shape (n, 6)."""
    continuous: np.ndarray
    """e predicted by the differential equation likewise [rad], shape (n, 6)."""


def error_dynamics(
    run: Run, kp: np.ndarray, kd: np.ndarray, counted: np.ndarray,
) -> ErrorDynamics:
    """
    Compare the recorded error with what the law promises.

    One period of the loop does d' = d + h(-Kd d - Kp e) + [qd* + h qdd* - qd*'] and
    e' = e + h d' + [q* + h qd*' - q*'], the brackets being what sampling the reference costs.
    A stretch is a run of counted periods; each is predicted from its first state on.

    Parameters
    ----------
    run : Run
        A recording with a reference.
    kp, kd : numpy.ndarray, shape (6, 6)
        Gains.
    counted : numpy.ndarray of bool, shape (n - 1,)
        Periods in which the law was in charge.

    Returns
    -------
    ErrorDynamics
        Error, defects and predictions.

    """
    h, n = run.h, len(run.stamp)
    q, qd, _ = run.exact
    star = run.reference
    error, rate = q - star.q, qd - star.qd
    jump = _jumps(star, h)  # (n - 1, 12)
    state = np.hstack([error, rate])
    sampled_step = sampled_matrix(kp, kd, h)
    step = state[1:] - state[:-1] @ sampled_step.T - jump
    step[~counted] = np.nan
    flow = exponential(h * continuous_matrix(kp, kd))
    sampled, continuous = np.full((2, n, 6), np.nan)
    for start, end in stretches(counted):
        rows = slice(start, end + 1)
        sampled[rows] = _follow(sampled_step, state[start], jump[start:end])[:, :6]
        continuous[rows] = _restart(flow, state[rows], jump[start:end], h)
    return ErrorDynamics(error, rate, step, sampled, continuous)


def sampled_matrix(kp: np.ndarray, kd: np.ndarray, h: float) -> np.ndarray:
    """Return the matrix that takes (e, d) to (e', d') in one period, shape (12, 12)."""
    one = np.eye(6)
    lower = np.hstack([-h * kp, one - h * kd])
    upper = np.hstack([one, np.zeros((6, 6))]) + h * lower
    return np.vstack([upper, lower])


def continuous_matrix(kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """Return the matrix A of (e, d)' = A (e, d), shape (12, 12)."""
    return np.block([[np.zeros((6, 6)), np.eye(6)], [-kp, -kd]])


def exponential(matrix: np.ndarray) -> np.ndarray:
    """Return the matrix exponential: a Taylor series of the scaled matrix, squared back."""
    halvings = max(0, int(np.ceil(np.log2(max(float(np.linalg.norm(matrix, 1)), 1e-300)))) + 4)
    small = matrix / 2.0**halvings
    term = total = np.eye(len(matrix))
    for order in range(1, 14):
        term = term @ small / order
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def stretches(counted: np.ndarray) -> list[tuple[int, int]]:
    """Return ``(first, end)`` of each run of True in a mask: periods first to end - 1."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], counted, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _jumps(star, h: float) -> np.ndarray:
    rate = star.qd[:-1] + h * star.qdd[:-1] - star.qd[1:]
    position = star.q[:-1] + h * star.qd[1:] - star.q[1:]
    return np.hstack([position + h * rate, rate])


def _follow(step: np.ndarray, first: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """Return x_0 .. x_n of x' = step x + input, BLOCK periods to one matrix product."""
    size, count = len(first), len(inputs)
    if not count:
        return first[None, :]
    blocks = -(-count // BLOCK)
    padded = np.zeros((blocks * BLOCK, size))
    padded[:count] = inputs
    powers = [np.eye(size)]
    for _ in range(BLOCK):
        powers.append(step @ powers[-1])
    kernel = np.zeros((BLOCK * size, BLOCK * size))
    for j in range(BLOCK):
        for i in range(j + 1):
            kernel[j * size:(j + 1) * size, i * size:(i + 1) * size] = powers[j - i]
    forced = (padded.reshape(blocks, -1) @ kernel.T).reshape(blocks, BLOCK, size)
    free = np.concatenate(powers[1:])  # (BLOCK size, size)
    out = np.empty((blocks * BLOCK + 1, size))
    out[0] = state = first
    for block in range(blocks):
        rows = forced[block] + (free @ state).reshape(BLOCK, size)
        out[block * BLOCK + 1:(block + 1) * BLOCK + 1] = rows
        state = rows[-1]
    return out[:count + 1]


def _restart(flow, state, jump, h):
    """Return e(t) of the free solution, started anew where the reference jumps."""
    rough = np.abs(jump[:, :6]).max(axis=1) + h * np.abs(jump[:, 6:]).max(axis=1) > 1e-3
    starts = [0, *(np.flatnonzero(rough) + 1).tolist(), len(state)]
    out = np.empty((len(state), 6))
    for a, b in zip(starts[:-1], starts[1:], strict=True):
        out[a:b] = _follow(flow, state[a], np.zeros((b - a - 1, 12)))[:, :6]
    return out
