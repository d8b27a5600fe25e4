"""The known arms that fit a recorded effort."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.current import are_factors_of_drives
from ur5_ros.analysis.effort.fit import misfit_of, torque_of, unexplained
from ur5_ros.analysis.effort.meanings import Hypothesis, effort_hypotheses
from ur5_ros.analysis.residual_blocks import sample_blocks
from ur5_ros.config import known_arms
from ur5_ros.model.parameters import ArmParameters

#: An arm that leaves more of the effort unexplained, as a share of it, does not fit.
LARGEST_MISFIT = 0.3

#: Lengths of two arms that differ by less are the same [m].
LENGTH_TOLERANCE = 1e-3


class ArmFit(NamedTuple):
    """How well a known arm fits the recorded torques."""

    name: str
    rms: float
    """Torque left unexplained, RMS of the worst joint [N m]."""
    misfit: float
    """The same relative to each joint's effort."""


def fitting_arms(run: Run) -> list[ArmFit]:
    """Return the known arms by how well they fit the recorded torques, best first."""
    found = []
    for name, arm in known_arms().items():
        samples = sample_blocks(run, arm)
        if samples is None:
            return []
        effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
        left = unexplained(effort, torque, samples)
        found.append(ArmFit(name, float(np.sqrt(np.mean(left**2, axis=0)).max()),
                            misfit_of(effort, torque, samples)))
    return sorted(found, key=lambda fit: (fit.rms, fit.name))


def arms_by_meaning(run: Run) -> list[tuple[str, Hypothesis]]:
    """Return the known arms with the meaning of the effort that fits them, best first."""
    found = []
    for name, arm in known_arms().items():
        likely = [each for each in effort_hypotheses(run, arm)
                  if each.meaning not in ('total', 'constant')
                  and (each.meaning != 'current' or are_factors_of_drives(each.factors))]
        found += [(name, likely[0])] if likely else []
    return sorted(found, key=lambda each: each[1].misfit)


def has_geometry_of(arm: ArmParameters, name: str) -> bool:
    """Return whether an arm has the lengths of a known one, signs of the angles aside."""
    other = known_arms()[name]
    return bool(np.abs(np.abs(arm.a) - np.abs(other.a)).max() < LENGTH_TOLERANCE
                and np.abs(np.abs(arm.d) - np.abs(other.d)).max() < LENGTH_TOLERANCE)
