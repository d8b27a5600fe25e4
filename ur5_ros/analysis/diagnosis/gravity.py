"""Another gravity, and a load under it: their torque is a product of both."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.diagnosis.selection import Causes, Fit
from ur5_ros.analysis.diagnosis.selection import fit as fit_causes
from ur5_ros.analysis.residual_blocks import SampleBlocks, unit_torques

#: Times that a load is fitted anew under the gravity that was found beside it.
GRAVITY_PASSES = 5

#: How far a real robot's gravity may be from none, the arm's own, or twice that, as a share.
GRAVITY_TOLERANCE = 0.02

#: Less than this is another gravity by rounding: its turn [rad], and the change of its size.
TURNED, CHANGED = np.radians(1.0), 5e-4


class Together(NamedTuple):
    """Gravity and a load fitted together."""

    left: float
    causes: Causes
    """With the load under that gravity."""


def gravity_with_load(causes: Causes, samples: SampleBlocks) -> Together | None:
    """Return gravity and a load fitted together: the torque is a product of both."""
    if not {'gravity', 'payload'} <= set(causes.units):
        return None
    names, found = ('gravity', 'payload'), causes
    for _ in range(GRAVITY_PASSES):
        both = fit_causes(found, names)
        if not np.isfinite(both.left):
            return None
        found = load_under(both, found, samples)
    return Together(fit_causes(found, names).left, found)


def load_under(fit: Fit, causes: Causes, samples: SampleBlocks) -> Causes:
    """Return the causes with a load that weighs what the gravity of a fit makes of it."""
    gravity = causes.arm.gravity + fit.value[fit.part('gravity', causes)]
    load = unit_torques(samples, replace(causes.arm, gravity=gravity))['payload']
    return causes._replace(units={**causes.units, 'payload': load})


def is_gravity_possible(fit: Fit, causes: Causes) -> bool:
    """Return whether a gravity among the causes is one that a real robot can have or count."""
    if 'gravity' not in fit.names:
        return True
    gravity = causes.arm.gravity
    found = gravity + fit.value[fit.part('gravity', causes)]
    own, size = float(np.linalg.norm(gravity)), float(np.linalg.norm(found))
    if min(abs(size / own - known) for known in (0.0, 1.0, 2.0)) >= GRAVITY_TOLERANCE:
        return False
    cosine = float(found @ gravity) / max(size * own, 1e-300)
    return cosine < np.cos(TURNED) or (abs(size / own - 1.0) > CHANGED and len(fit.names) == 1)
