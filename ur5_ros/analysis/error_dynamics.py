"""Error dynamics: the recorded e(t) against e'' + Kd e' + Kp e = 0, sampled and continuous."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.laws import Law
from ur5_ros.analysis.plant_integrator import PlantModel, predict
from ur5_ros.analysis.residual import CHUNK
from ur5_ros.model.dynamics import inverse_dynamics

#: Samples that one matrix product takes.
BLOCK_SAMPLES = 16


class ErrorDynamics(NamedTuple):
    """The tracking error and what theory predicts."""

    error: np.ndarray
    """q - q* [rad], shape (n, 6); NaN where no reference is recorded."""
    rate: np.ndarray
    """qd - qd* [rad/s], shape (n, 6)."""
    step: np.ndarray
    """Defect of the sampled equation over one period [rad, rad/s], shape (n - 1, 12)."""
    sampled: np.ndarray
    """e predicted by the sampled equation from the start of its stretch [rad], shape (n, 6)."""
    cost: np.ndarray
    """What sampling the reference and holding the torque cost: the same from rest [rad]."""
    continuous: np.ndarray
    """e predicted by the differential equation likewise [rad], shape (n, 6)."""


def error_dynamics(run: Run, laws: Sequence[Law], counted: np.ndarray) -> ErrorDynamics:
    """
    Compare the recorded error with what the law promises.

    One period of the loop does d' = d + h(-Kd d - Kp e) + rate and e' = e + h d' + position,
    with what one period takes the plant away from the reference when it starts on it: rate =
    qd* + h qdd* - qd*' and position = q* + h qd*' - q*'.  With n physics steps a period the torque
    that follows the reference is held over them; then this holds as far as the error is small.
    ``counted`` are the periods in which the law was active, shape (n - 1,). A stretch is a
    sequence of them; each is predicted from its first state on, with the gains in force.

    """
    h, n = run.h, len(run.stamp)
    q, qd, _ = run.exact
    star = run.required_reference
    error, rate = q - star.q, qd - star.qd
    jump = _jumps(run)  # (n - 1, 12)
    state = np.hstack([error, rate])
    step = np.full((n - 1, 12), np.nan)
    sampled, cost, continuous = np.full((3, n, 6), np.nan)
    matrices = []
    for law in laws:
        once = sampled_matrix(*law.gains, h, run.substeps or 1)
        matrices.append((once, exponential(h * continuous_matrix(*law.gains))))
        rows = slice(law.first, min(law.end, n - 1))
        step[rows] = state[1:][rows] - state[rows] @ once.T - jump[rows]
    step[~counted] = np.nan
    for start, end in stretches(counted):
        held, rest, free = state[start], np.zeros(12), state[start]
        for law, (once, flow) in zip(laws, matrices, strict=True):
            a, b = max(start, law.first), min(end, law.end)
            if a < b:
                rows = slice(a, b + 1)
                followed = _follow(once, held, jump[a:b])
                costs = _follow(once, rest, jump[a:b])
                left = _restart(flow, free, state[rows], jump[a:b], h)
                sampled[rows], cost[rows] = followed[:, :6], costs[:, :6]
                continuous[rows] = left[:, :6]
                held, rest, free = followed[-1], costs[-1], left[-1]
    return ErrorDynamics(error, rate, step, sampled, cost, continuous)


def sampled_matrix(kp: np.ndarray, kd: np.ndarray, h: float, substeps: int = 1) -> np.ndarray:
    """
    Return the matrix that takes (e, d) to (e', d') in one period, shape (12, 12).

    The acceleration -Kp e - Kd d is held over ``substeps`` steps of semi-implicit Euler.

    """
    one, held = np.eye(6), 0.5 * h**2 * (substeps + 1) / substeps
    return np.block([[one - held * kp, h * one - held * kd], [-h * kp, one - h * kd]])


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


def _jumps(run: Run) -> np.ndarray:
    """Return where a period that starts on the reference ends, from the reference, (n - 1, 12)."""
    star, arm, n = run.required_reference, run.required_control.arm, run.substeps
    if n <= 1:
        rate = star.qd[:-1] + run.h * star.qdd[:-1] - star.qd[1:]
        return np.hstack([star.q[:-1] + run.h * (star.qd[1:] + rate) - star.q[1:], rate])
    jump = np.full((len(star.q) - 1, 12), np.nan)
    known = np.flatnonzero(run.has_reference[:-1])
    for start in range(0, len(known), CHUNK):
        rows = known[start:start + CHUNK]
        q, qd, qdd = (part[rows] for part in star)
        torque = inverse_dynamics(q + arm.angle_offset, qd, qdd, arm)
        torque = np.repeat(torque[:, None], n, axis=1)
        q, qd = predict(PlantModel(arm), q, qd, torque, run.h / n, n)
        jump[rows] = np.hstack([q - star.q[rows + 1], qd - star.qd[rows + 1]])
    return jump


def _follow(step: np.ndarray, first: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """Return x_0 .. x_n of x' = step x + input, BLOCK_SAMPLES periods to one matrix product."""
    size, count = len(first), len(inputs)
    if not count:
        return first[None, :]
    blocks = -(-count // BLOCK_SAMPLES)
    padded = np.zeros((blocks * BLOCK_SAMPLES, size))
    padded[:count] = inputs
    powers = [np.eye(size)]
    for _ in range(BLOCK_SAMPLES):
        powers.append(step @ powers[-1])
    kernel = np.zeros((BLOCK_SAMPLES * size, BLOCK_SAMPLES * size))
    for j in range(BLOCK_SAMPLES):
        for i in range(j + 1):
            kernel[j * size:(j + 1) * size, i * size:(i + 1) * size] = powers[j - i]
    forced = (padded.reshape(blocks, -1) @ kernel.T).reshape(blocks, BLOCK_SAMPLES, size)
    free = np.concatenate(powers[1:])  # (BLOCK_SAMPLES size, size)
    out = np.empty((blocks * BLOCK_SAMPLES + 1, size))
    out[0] = state = first
    for block in range(blocks):
        rows = forced[block] + (free @ state).reshape(BLOCK_SAMPLES, size)
        out[block * BLOCK_SAMPLES + 1:(block + 1) * BLOCK_SAMPLES + 1] = rows
        state = rows[-1]
    return out[:count + 1]


def _restart(flow, first, state, jump, h):
    """Return x(t) of the free solution from ``first``, started anew where the reference jumps."""
    rough = np.abs(jump[:, :6]).max(axis=1) + h * np.abs(jump[:, 6:]).max(axis=1) > 1e-3
    starts = [0, *(np.flatnonzero(rough) + 1).tolist(), len(state)]
    out = np.empty_like(state)
    for a, b in zip(starts[:-1], starts[1:], strict=True):
        out[a:b] = _follow(flow, state[a] if a else first, np.zeros((b - a - 1, 12)))
    return out
