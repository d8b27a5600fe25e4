"""The torque that the law's arm leaves unexplained, and every cause that may explain it."""

from dataclasses import replace

import numpy as np

from ur5_ros.analysis.diagnosis.link_body import link_units
from ur5_ros.analysis.diagnosis.measurement import measurement_units
from ur5_ros.analysis.diagnosis.selection import Causes
from ur5_ros.analysis.residual_blocks import SampleBlocks, is_noise, sliding, unit_torques
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters

#: Unexplained torque under this share of the largest joint's does not weigh more for being small.
SMALL_EXACT, SMALL_MEASURED = 1e-6, 0.02

#: A joint that shows noise alone weighs so many times less, or the noise of five joints hides the
#: fault of one.
NOISE_WEIGHS = 10.0

#: Positions within this are one pose [rad].
ONE_POSE = 1e-3


def candidates(samples: SampleBlocks, arm: ArmParameters, weightless: bool,
               rests: bool, measured: bool) -> Causes:
    """
    Return the unexplained torque and what may explain it; standing still, not friction.

    ``weightless``: the effort was recorded without gravity, that of a load included;
    ``measured``: a robot measured it, which may be wrong.

    """
    units = unit_torques(samples, arm)
    if weightless:
        units['payload'] = unit_torques(samples, replace(arm, gravity=np.zeros(3)))['payload']
        del units['gravity']
    if measured:
        units |= measurement_units(samples, samples.effort - samples.unexplained_torque,
                                   weightless)
    units |= link_units(samples, replace(arm, gravity=np.zeros(3)) if weightless else arm)
    torque = samples.unexplained_torque.mean(axis=1)
    known = sliding(samples)
    if rests or not known.any():  # gravity and a load alone act at rest
        known, rests = np.ones_like(known), True
        units = {name: units[name] for name in ('payload', 'gravity') if name in units}
    counted = np.maximum(known.sum(axis=0), 1)
    scale = np.sqrt(np.sum(np.where(known, torque, 0.0)**2, axis=0) / counted)
    # a joint whose torque is small may be all noise, which other joints' columns would then fit
    least = 1.0 if rests else SMALL_EXACT if samples.exact else SMALL_MEASURED
    scale = np.maximum(scale, least * scale.max())
    if not rests and not samples.exact and not is_noise(torque).all():
        scale = np.where(is_noise(torque), NOISE_WEIGHS * scale, scale)
    weight = known / np.maximum(scale, 1e-300) / np.sqrt(counted)
    return Causes(torque, weight, units, arm)


def rests_in_one_pose(samples: SampleBlocks) -> bool:
    """Return whether the arm stays in one pose."""
    return float(np.ptp(samples.q.mean(axis=1), axis=0).max()) < ONE_POSE


def at_mean_pose(samples: SampleBlocks, arm: ArmParameters) -> SampleBlocks:
    """Return the samples of an arm at rest in its mean pose: its noise is no motion."""
    q = np.broadcast_to(samples.q.mean(axis=(0, 1)), samples.q.shape)
    rest = np.zeros(samples.q.shape)
    return samples._replace(q=q, qd=rest, qdd=rest, qd_next=rest,
                            unexplained_torque=samples.effort - gravity_torque(q, arm))
