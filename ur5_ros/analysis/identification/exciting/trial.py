"""A trial of an excitation trajectory: the errors that a noisy recording of it has."""

import numpy as np

from ur5_ros.analysis.data.run import Run, States
from ur5_ros.analysis.identification.base_parameters import all_parameters, base_of
from ur5_ros.analysis.identification.exciting.excitation import NOISE_RATE, Excitation
from ur5_ros.analysis.identification.identify import fit_base
from ur5_ros.control.profiles import joint_waves
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters


def trial_errors(found: Excitation, arm: ArmParameters, seed: int = 0):
    """
    Return the standard errors and the errors of a fit to a noisy recording of the motion.

    ``found``: the motion; the torque has its white noise, and no friction.  Returned: ``error``,
    ``away`` (p,): standard errors that the fit gives, and how far its values are from the truth;
    in the order of ``found.names``.
    """
    t = np.arange(0.0, found.experiment.duration, 1.0 / NOISE_RATE)
    motion = joint_waves(t, found.experiment)
    torque = inverse_dynamics(motion.q + arm.angle_offset, motion.qd, motion.qdd, arm)
    noise = np.random.default_rng(seed).normal(0.0, 1.0, torque.shape) * found.noise
    stamp = np.rint(t * 1e9).astype(np.int64) + 1_000_000
    run = Run('trial', stamp, States(motion.q, motion.qd, torque + noise), NOISE_RATE)
    estimate = fit_base([run], arm)
    true = np.concatenate([base_of(arm).combination @ all_parameters(arm), np.zeros(12)])
    return estimate.error, np.abs(estimate.value - true)
