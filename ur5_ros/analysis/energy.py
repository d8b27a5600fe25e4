"""Energy balance and passivity: what the arm gained against what was put in."""

from typing import Any

import numpy as np

from ur5_ros.analysis.residual import CHUNK
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.analysis.scheme import schemes
from ur5_ros.analysis.series import Run
from ur5_ros.config.validation import Marks
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.kinematics import link_transforms

_NAMES = ('energy balance', 'passivity')


def energy_checks(run: Run, marks: Marks) -> tuple[list[Check], dict[str, Any]]:
    """
    Return the checks of the energy balance and of passivity, and the surplus for the figure.

    Work over one period is (effort - friction + wrench) times the mean of the two velocities,
    which is exact for a constant M; the surplus is energy gained minus work done.  A passive arm
    never has more than was put in.

    Parameters
    ----------
    run : Run
        The recording.
    marks : Marks
        Pass marks.

    """
    if run.sim is None or not run.substeps:
        why = "the plant's friction and payload are not known"
        return [not_applicable(name, why) for name in _NAMES], {}
    plan = schemes(run)
    if len(plan) > 1 or not run.steps.any():
        why = ('the plant was changed during the run' if len(plan) > 1
               else 'no state is followed by the one a period later')
        return [not_applicable(name, why) for name in _NAMES], {}
    scheme = plan[0][1]
    q, qd, effort = run.exact
    stored, work = _stored(q, qd, scheme.arm), _work(run, scheme)
    moved = float(np.nansum(np.abs(work)))
    surplus = np.where(np.isfinite(work), np.diff(stored) - work, 0.0)
    total = np.cumsum(surplus)
    limit = marks['energy'] * max(moved, float(np.ptp(stored))) + run.h * float(
        np.nanmax(np.abs(np.einsum('ni,ni->n', effort, qd))))
    worst = float(np.abs(total).max())
    gained = float(max(total.max(), 0.0))
    row = int(np.argmax(np.abs(total)))
    words = f'{moved:.4g} J moved back and forth'
    return [
        judge('energy balance', worst, limit, 'J',
              f'energy gained and work done differ by at most {worst:.3g} J at '
              f'{run.t[row]:.4g} s; {words}', moved_J=moved),
        judge('passivity', gained, limit, 'J',
              f'the arm never holds more than {gained:.3g} J beyond what was put in; {words}',
              moved_J=moved),
    ], {'surplus': total}


def _stored(q: np.ndarray, qd: np.ndarray, arm) -> np.ndarray:
    mass, com, _ = arm.bodies
    out = np.empty(len(q))
    for start in range(0, len(q), CHUNK):
        rows = slice(start, start + CHUNK)
        angles = q[rows] + arm.angle_offset
        frames = link_transforms(angles, arm)
        centres = np.einsum('nlij,lj->nli', frames[..., :3, :3], com) + frames[..., :3, 3]
        potential = -np.einsum('nli,i,l->n', centres, arm.gravity, mass)
        kinetic = 0.5 * np.einsum('ni,nij,nj->n', qd[rows], inertia_matrix(angles, arm), qd[rows])
        out[rows] = kinetic + potential
    return out


def _work(run: Run, scheme) -> np.ndarray:
    q, qd, effort = run.exact
    mean = 0.5 * (qd[1:] + qd[:-1])
    torque = effort[1:] - scheme.friction(mean) + scheme.external(q[:-1])
    work = run.h * np.einsum('ni,ni->n', torque, mean)
    return np.where(run.steps, work, np.nan)
