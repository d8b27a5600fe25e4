"""What the laws promise, as formulas: a test holds the law against each."""

import numpy as np

from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.adaptive import Adaptive
from ur5_ros.control.laws.law import model_terms
from ur5_ros.control.laws.slotine_li import error_bandwidth, sliding_variable
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import base_parameters, inertial_parameters
from ur5_ros.signals import ArmState, Reference


def steady_state_error(q: np.ndarray, arm: ArmParameters, gains: Gains,
                       law_arm: ArmParameters | None = None) -> np.ndarray:
    r"""
    Return q - q* of an arm at rest under ``pd``, ``gravity_pd`` or ``impedance`` [rad].

    The spring carries the gravity that the law does not know: :math:`K_P e = \hat g - g` at the
    positions that are reached.

    ``q`` (6,): positions reached [rad]; ``gains``: KP [N m/rad]; ``law_arm``: the arm of a law
    that adds g(q); ``pd`` adds none.
    """
    known = 0.0 if law_arm is None else gravity_torque(q + law_arm.angle_offset, law_arm)
    return np.linalg.solve(gains.kp, known - gravity_torque(q + arm.angle_offset, arm))


def error_energy(state: ArmState, reference: Reference, arm: ArmParameters,
                 gains: Gains) -> float:
    r"""
    Return :math:`V = \frac12 s^T M s` [J], which the law makes fall.

    With an exact model :math:`\dot V = -s^T K s`, K = KD^1/2 M KD^1/2: for KD = k I, V(t) = V(0)
    exp(-2 k t).
    """
    s = sliding_variable(state, reference, error_bandwidth(gains)).s
    return float(0.5 * s @ model_terms(state, arm)[0] @ s)


def base_values(law_arm: ArmParameters, true_arm: ArmParameters) -> np.ndarray:
    """Return what the estimate of ``Adaptive`` would be for an arm as it is, shape (b,)."""
    return base_parameters(law_arm).combination @ inertial_parameters(true_arm)


def lyapunov(law: Adaptive, true: np.ndarray, state: ArmState, reference: Reference,
             true_arm: ArmParameters) -> float:
    """Return V of ``Adaptive`` for the arm as it is, of base values ``true`` [J]."""
    error = law.estimate - true
    return (error_energy(state, reference, true_arm, law.gains)
            + float(0.5 * error @ (error / law.adaptation)))


def layer_width(gains: Gains, boundary_layer: np.ndarray,
                disturbance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""
    Return the bounds of :math:`|s|` [rad/s] and :math:`|e|` [rad] that the law promises.

    Inside the layer :math:`\dot s = -K_D s + d`, so that :math:`|s_i| \le D_i / k_i` once what
    was at the start has died out, and :math:`|e_i| \le |s_i| / \lambda_i`.

    ``boundary_layer`` (6,): phi [rad/s]; ``disturbance`` (6,): largest |d| = |M^-1 (torque that
    the model lacks)| [rad/s^2].  Returned: infinite where the disturbance exceeds what the law
    pushes with, KD Phi, (6,), (6,).
    """
    kp, kd = np.diag(gains.kp), np.diag(gains.kd)
    s = np.where(disturbance < kd * boundary_layer, disturbance / kd, np.inf)
    return s, s * kd / kp


def remaining_disturbance(disturbance: np.ndarray, gain: float, time: float) -> np.ndarray:
    """
    Return what is left of a constant disturbance some time after it began [N m].

    ``disturbance`` (6,): joint torque that the model lacks [N m]; ``gain``: ``observer_gain``
    [1/s]; ``time``: since it began [s].
    """
    return disturbance * np.exp(-gain * time)
