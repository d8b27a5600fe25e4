"""Residuals as torque: of the equations of motion, and of the command."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.compensation import robot_compensation
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import PlantModel, predict
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Rows that one pass takes, so that memory stays flat.
CHUNK = 16384

#: Speed below which a joint sticks [rad/s]; in the simulator it is rounding, 1e-16.
STICKING_SPEED = 1e-12


class Residual(NamedTuple):
    """Defect of every recorded period; NaN where it is not known."""

    torque: np.ndarray
    """Residual [N m], shape (n - 1, 6)."""
    position: np.ndarray
    """Defect of q' = q + h qd' [rad], shape (n - 1, 6)."""


def residual(run: Run, models: list[tuple[int, PlantModel]]) -> Residual:
    """
    Return the residual of every period.

    r_k = M(q_k)(qd_{k+1} - qd_k)/h + C qd_k + g + D qd_{k+1} + f(qd_{k+1}) - J^T w - effort_{k+1},
    D, f and w being the friction and the wrench of the plant model in force from each row of
    ``models`` on; where there is a world, the torque of its contacts adds to the effort.  With n
    physics steps a period the model is integrated n times, and r_k = M(q_k)(qd_{k+1} -
    prediction)/(n h).  Exact states are used where they are recorded; a joint at its stop is left
    out.

    """
    q, qd, _ = run.exact
    last = len(q) - 1
    whole = run.steps
    torque = np.full((last, 6), np.nan)
    position = torque.copy()
    ends = [first for first, _ in models[1:]] + [last]
    for (first, model), end in zip(models, ends, strict=True):
        for start in range(first, min(end, last), CHUNK):
            rows = np.arange(start, min(start + CHUNK, end, last))
            rows = rows[whole[rows]]
            if len(rows):
                torque[rows], position[rows] = _defects(
                    model, q[rows], qd[rows], run.applied(rows), q[rows + 1], qd[rows + 1], run)
    return Residual(torque, position)


def _defects(model, q, qd, effort, q_next, qd_next, run):
    """Return torque and position defect of these periods, each of shape (n, 6)."""
    h, n = 1.0 / run.physics_rate, run.substeps
    angles = q + model.arm.angle_offset
    if n == 1:
        torque = inverse_dynamics(angles, qd, (qd_next - qd) / h, model.arm) - effort[:, 0]
        damping, level, offset = model.friction_terms(q, qd)
        torque += damping * qd_next + offset - model.external(q)
        torque = _beyond_dry(torque, qd_next, level)
        position = q_next - q - h * qd_next
    else:
        q_end, qd_end = predict(model, q, qd, effort, h, n)
        gap = (qd_next - qd_end) / (n * h)
        torque = np.einsum('nij,nj->ni', inertia_matrix(angles, model.arm), gap)
        position = q_next - q_end
    torque[at_stop(q_next, model.arm)] = np.nan  # the reaction of the stop is not recorded
    return torque, position


def at_stop(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """Return which joints of positions ``q`` [rad], shape (..., 6), are at a position limit."""
    return (q >= arm.limits.upper - 1e-9) | (q <= arm.limits.lower + 1e-9)


def command_defect(run: Run) -> np.ndarray:
    """
    Return effort of state k+1 minus the command of state k, shape (n - 1, 6) [N m].

    Gravity and friction compensation are added to the command where the plant adds them.  NaN
    where there is no answer, no successor or no torque mode in which it would act, zero where a
    torque limit explains the difference.

    """
    q, _, effort = run.exact
    command = run.required_command[:-1].copy()
    if run.sim:
        command[rows_since(run, 'torque_mode', False)] = np.nan
        command = _limited(command, run)
    if run.sim and run.sim.parameters.get('effort_convention') == 'gravity_excluded':
        command += gravity_torque(q[:-1] + run.sim.arm.angle_offset, run.sim.arm)
    if (added := robot_compensation(run)) is not None:
        command += added
    if run.sim:
        limit = run.sim.arm.limits.effort
        command = np.clip(command, -limit, limit)
    defect = effort[1:] - command
    defect[~run.steps] = np.nan
    return defect


def rows_since(run: Run, kind: str, active: bool) -> np.ndarray:
    """
    Return the rows, but the last, from an event of a kind up to its opposite.

    ``kind``: kind of the event, such as ``fallback``; ``active``: what it says.  Returned: shape
    (n - 1,), bool.
    """
    found = np.zeros(len(run.stamp), dtype=bool)
    for event in run.events:
        if event.kind == kind:
            first = np.searchsorted(run.stamp, event.stamp)
            found[first:] = bool(event.values.get('active')) == active
    return found[:-1]


def _limited(command: np.ndarray, run: Run) -> np.ndarray:
    """Return commands within the limits of torque mode."""
    parameters = run.required_sim.parameters
    largest = np.array(parameters.get('torque_limit') or [np.inf] * 6)
    change = parameters.get('torque_rate_limit', 0.0) * run.h
    if change:
        command, last = command.copy(), np.zeros(6)
        for row, silent in zip(command, rows_since(run, 'fallback', True), strict=True):
            if silent:
                last = np.zeros(6)
            elif np.isfinite(row).all():
                row[:] = last = np.clip(row, np.maximum(-largest, last - change),
                                        np.minimum(largest, last + change))
    return np.clip(command, -largest, largest)


def _beyond_dry(torque: np.ndarray, qd_next: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Return what is left when dry friction takes its share: all it can where it sticks."""
    sticking = np.abs(qd_next) <= STICKING_SPEED
    return np.where(sticking, torque - np.clip(torque, -level, level),
                    torque + level * np.sign(qd_next))
