"""Energy balance and passivity: energy gained against work done."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import PlantModel, path, plant_models
from ur5_ros.analysis.residual import CHUNK, STICKING_SPEED, at_stop
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.model.dynamics import inertia_matrix, inverse_dynamics
from ur5_ros.model.energy import potential_energy

_NAMES = ('energy balance', 'passivity')

#: Energy that rounding makes of a hundred joules over a long run [J].
ROUNDING_ENERGY = 1e-9
#: Work below which a limit that exceeds it is no reason for doubt [J].
SMALL_WORK = 1.0


class Balance(NamedTuple):
    """Energy gained minus work done, and what the time step adds to it."""

    surplus: np.ndarray
    """Of every period [J], shape (n - 1,); zero where it is not known."""
    moved: float
    """Work moved back and forth [J]."""
    discretisation: float
    """What the time step may cost [J]."""


def energy_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """
    Return the checks of the energy balance and of passivity, and the surplus for the figure.

    A passive arm never has more than was put in; see :func:`balance`.

    """
    if run.sim is None or not run.substeps or not run.steps.any():
        why = ("the plant's friction and payload are not known" if not run.substeps else
               'no state is followed by the one a period later')
        return [not_applicable(name, why) for name in _NAMES], {}
    found = balance(run, plant_models(run))
    total = np.cumsum(found.surplus)
    limit = marks['energy'] * found.discretisation + ROUNDING_ENERGY
    worst = float(np.abs(total).max())
    gained = float(max(total.max(), 0.0))
    row = int(np.argmax(np.abs(total)))
    words = f'work of {found.moved:.4g} J was done, in both directions'
    if limit > max(found.moved, SMALL_WORK):
        why = (f'one time step may cost {limit:.3g} J, more than the work done ({found.moved:.3g} '
               'J): nothing can be concluded')
        return [not_applicable(name, why, moved_J=found.moved) for name in _NAMES], {}
    return [
        judge('energy balance', worst, limit, 'J',
              f'energy gained and work done differ by at most {worst:.3g} J at '
              f'{run.t[row]:.4g} s; {words}', moved_J=found.moved),
        judge('passivity', gained, limit, 'J',
              f'the arm gains at most {gained:.3g} J more than the work done on it; {words}',
              moved_J=found.moved),
    ], {'surplus': total}


def balance(run: Run, models: list[tuple[int, PlantModel]]) -> Balance:
    """
    Return energy gained against work done, period by period.

    The simulator's scheme is qd' = qd + h a(q, qd), q' = q + h qd': its velocities belong half a
    step before its positions.  Energy is therefore taken at q with the mean of the velocities
    before and after it, and the work of h qd' by the mean of the torques at both its ends; the
    scheme's Coriolis torque, at qd instead of that mean, is corrected.  What is left is of the
    second order in h: a quarter of the change of 1/2 (qd' - qd)^T M (qd' - qd), and less; where a
    joint begins or ceases to stick, half of the jump of its friction over one step.  Energies
    under different plant models are not compared.

    """
    last = len(run.stamp) - 1
    # a stop takes energy that is not recorded
    whole = run.steps & ~at_stop(run.exact.q[1:], run.required_sim.arm).any(axis=1)
    surplus, moved, cost = np.zeros(last), 0.0, 0.0
    ends = [first for first, _ in models[1:]] + [last]
    for (begin, model), end in zip(models, ends, strict=True):
        for start in range(begin, min(end, last), CHUNK):
            rows = np.arange(start, min(start + CHUNK + 1, end, last))
            stored, force, dry, distance, jerk = _physics_steps(run, model, rows[whole[rows]])
            period = np.repeat(rows[whole[rows]], run.substeps)
            follows = np.diff(period) <= 1
            work = 0.5 * np.einsum('ni,ni->n', force[1:] + force[:-1], distance[:-1])
            gain = np.where(follows & np.isfinite(work), np.diff(stored) - work, 0.0)
            surplus += np.bincount(period[:-1], gain, last)
            moved += float(np.nansum(np.abs(work[follows])))
            grip = 0.5 * np.einsum('ni,ni->n', np.abs(np.diff(dry, axis=0)), np.abs(distance[:-1]))
            cost += float(np.nansum((np.abs(np.diff(jerk)) + grip)[follows]))
    return Balance(surplus, moved, cost)


def _physics_steps(run: Run, model: PlantModel, rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return for each physics step: energy, torque, dry friction, distance, 1/2 dqd^T M dqd."""
    q, qd, _ = run.exact
    h, n, arm = 1.0 / run.physics_rate, run.substeps, model.arm
    effort = run.applied(rows).reshape(-1, 6)
    q, qd, q_next, qd_next = path(model, (q[rows], qd[rows]), (q[rows + 1], qd[rows + 1]),
                                  effort, h, n)
    angles, mean, change = q + arm.angle_offset, 0.5 * (qd + qd_next), qd_next - qd
    known = np.isfinite(angles + change).all(axis=1)
    angles, change = np.where(known[:, None], (angles, change), 0.0)
    inertia, still = inertia_matrix(angles, arm), np.zeros(q.shape)
    mean, before = np.where(known[:, None], (mean, qd), 0.0)
    stored = potential_energy(angles, arm) + _half_square(inertia, mean)
    damping, *dry_friction = model.friction_terms(angles - arm.angle_offset, before)
    dry = _dry(model, angles, before, change / h, effort, qd_next, *dry_friction)
    force = effort - damping * qd_next - dry + model.external(q)
    force += (inverse_dynamics(angles, mean, still, arm)
              - inverse_dynamics(angles, before, still, arm))
    force[~known] = np.nan
    return stored, force, dry, q_next - q, _half_square(inertia, change)


def _half_square(inertia: np.ndarray, x: np.ndarray) -> np.ndarray:
    return 0.5 * np.einsum('ni,ni->n', (inertia @ x[:, :, None])[:, :, 0], x)


def _dry(model, angles, qd, qdd, effort, qd_next, level, offset) -> np.ndarray:
    """Return the dry friction; where a joint sticks, what the motion shows."""
    dry = offset + level * np.sign(qd_next)
    sticks = (np.abs(qd_next) <= STICKING_SPEED) & (level > 0.0)
    rows = np.flatnonzero(sticks.any(axis=1))
    if len(rows):
        needed = inverse_dynamics(angles[rows], qd[rows], qdd[rows], model.arm)
        given = effort[rows] + model.external(angles[rows] - model.arm.angle_offset)
        taken = np.clip(given - needed, (offset - level)[rows], (offset + level)[rows])
        dry[rows] = np.where(sticks[rows], taken, dry[rows])
    return dry
