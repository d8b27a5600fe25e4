"""Cause of a residual that appears only while something is touched: contact torque left out."""

from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import plant_models
from ur5_ros.analysis.residual import residual
from ur5_ros.model.kinematics import jacobian

#: Share of the squared residual that must lie within the time of contact.
CONTACT_SHARE = 0.99


def contact_cause(run: Run, limit: float) -> dict[str, Any] | None:
    """
    Return contact torque that acted and is not recorded, where it explains the residual.

    ``limit``: mark of the residual [N m].  Returned: ``kind``, ``sentence``, ``share``,
    ``bodies``, the largest force that is missing [N].
    """
    if run.contact is None or not run.substeps or run.noisy:
        return None
    spans = _spans(run)
    torque = np.nan_to_num(residual(run, plant_models(run)).torque)
    rows = np.flatnonzero(np.abs(torque).max(axis=1) > limit)
    if not len(rows) or not spans:
        return None
    touched = np.zeros(len(torque), dtype=bool)
    for _, first, last in spans:
        touched[first:last] = True
    power = np.sum(torque**2, axis=1)
    share = float(power[touched].sum() / power.sum())
    if share < CONTACT_SHARE:
        return None
    worst = int(np.argmax(power))
    pair = next(bodies for bodies, first, last in spans if first <= worst < last)
    arm = run.required_sim.arm
    J = jacobian(run.exact.q[worst] + arm.angle_offset, arm)
    force = float(np.linalg.norm(np.linalg.lstsq(J.T, torque[worst], rcond=1e-9)[0][:3]))
    return {'kind': 'contact', 'share': share, 'bodies': list(pair), 'force': force,
            'sentence': f'contact torque is missing in the record: {" and ".join(pair)} touch, '
            f'and up to {force:.4g} N at the tool ({run.t[worst]:.4g} s) are not in '
            '~/contact_effort'}


def _spans(run: Run) -> list[tuple[tuple[str, str], int, int]]:
    """Return bodies, first and last row of each contact that the events report."""
    found, begun, end = [], {}, len(run.stamp) - 1
    for event in run.events:
        if event.kind != 'contact':
            continue
        bodies = tuple(event.values['bodies'])
        row = int(np.searchsorted(run.stamp, event.stamp))
        if event.values['active']:
            begun[bodies] = row
        elif bodies in begun:
            found.append((bodies, begun.pop(bodies), row))
    return found + [(bodies, row, end) for bodies, row in begun.items()]
