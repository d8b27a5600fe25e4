"""Which known arm the plant is rather than the law's, friction beside it or none."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.diagnosis.differences import differences
from ur5_ros.analysis.diagnosis.selection import Causes, Fit, choose, fit
from ur5_ros.analysis.residual_blocks import SampleBlocks
from ur5_ros.config import known_arms
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Causes that are looked for beside another arm.
BESIDE = ('viscous friction', 'Coulomb friction')


class OtherArm(NamedTuple):
    """A known arm in place of the law's."""

    name: str
    left: float
    """What it leaves of the squared unexplained torque, as a share of that."""
    beside: Fit | None = None
    """Friction found beside it."""
    causes: Causes | None = None
    """What that was found in."""


def best_arm(samples: SampleBlocks, arm: ArmParameters, weight: np.ndarray) -> OtherArm:
    """Return the known arm that leaves least unexplained, with the same load."""
    total = _power(samples.unexplained_torque.mean(axis=1), weight)
    found = OtherArm('', np.inf)
    for name, other in known_arms().items():
        left = _power(_missing(samples, arm, other), weight) / total
        if left < found.left:
            found = OtherArm(name, left)
    return found


def best_arm_with_friction(samples: SampleBlocks, arm: ArmParameters, causes: Causes,
                           least: float) -> OtherArm:
    """Return the known arm that leaves least unexplained where friction is fitted beside it."""
    total = _power(causes.torque, causes.weight)
    units = {name: causes.units[name] for name in BESIDE if name in causes.units}
    found, theirs = OtherArm('', np.inf), causes
    for name, other in known_arms().items():
        missing = _missing(samples, arm, other)
        trial = causes._replace(torque=missing, units=units)
        left = fit(trial, tuple(units)).left * _power(missing, causes.weight) / total
        if left < found.left:
            found, theirs = OtherArm(name, left), trial
    return found._replace(beside=choose(theirs, least), causes=theirs)


def arm_cause(name: str, arm: ArmParameters, share: float, samples: SampleBlocks,
              weight: np.ndarray) -> dict[str, Any]:
    """Return the cause that the plant is another arm, with every parameter that differs."""
    plant = replace(known_arms()[name], payload=arm.payload)
    mending = differences(arm, plant, samples, (weight > 0.0).astype(float))
    return {
        'kind': 'wrong arm', 'arm': name, 'share': share,
        'differences': [each._asdict() for each in mending.differences],
        'unexplained_rms': mending.before, 'mended_rms': mending.after,
        'sentence': f"the plant moves as arm {name}, not as the controller's arm {arm.name}: "
        f'{mending.words()}; the unexplained torque falls from {mending.before:.3g} to '
        f'{mending.after:.2g} N m RMS'}


def _missing(samples: SampleBlocks, arm: ArmParameters, other: ArmParameters) -> np.ndarray:
    """Return what another arm leaves of the effort, block means (b, 6)."""
    angles = samples.q - arm.angle_offset + other.angle_offset
    loaded = replace(other, payload=arm.payload)
    torque = inverse_dynamics(angles, samples.qd, samples.qdd, loaded)
    missing: np.ndarray = (samples.effort - torque).mean(axis=1)
    return missing


def _power(torque: np.ndarray, weight: np.ndarray) -> float:
    return float(np.sum((torque * weight)**2))
