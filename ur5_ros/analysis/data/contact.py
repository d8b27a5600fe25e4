"""Contact in a recording: torque of every physics step, forces and bodies now and then."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ur5_ros.cdr.contact_messages import decode_markers, decode_poses


def contact_series(messages: Iterable[tuple[str, bytes]]) -> dict[str, Any]:
    """
    Return ``contact_forces`` and ``objects`` of a run from its messages.

    ``messages``: role and CDR bytes, in order of time; other roles are left out.
    """
    forces, objects = [], []
    for role, data in messages:
        if role == 'contacts':
            forces.append(decode_markers(data))
        elif role == 'objects':
            objects.append(decode_poses(data))
    return {'contact_forces': tuple(forces), 'objects': tuple(objects)}


def contact_rows(stamp: np.ndarray, physics_rate: float, substeps: int, at: np.ndarray,
                 torque: np.ndarray) -> np.ndarray:
    """
    Return the contact torque of the physics steps up to each state.

    ``stamp`` (n,): of the states [ns]; ``at`` (m,): stamps of the recorded torques, each at the
    end of its step [ns]; ``torque`` (m, 6): [N m].  Returned: [N m]; zero where none was recorded,
    (n, substeps, 6).
    """
    rows = np.zeros((len(stamp), substeps, 6))
    state = np.searchsorted(stamp, at)
    known = state < len(stamp)
    state, at = state[known], at[known]
    before = np.rint((stamp[state] - at) * 1e-9 * physics_rate).astype(int)
    good = before < substeps
    rows[state[good], substeps - 1 - before[good]] = torque[known][good]
    return rows
