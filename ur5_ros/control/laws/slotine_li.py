"""Slotine and Li's passivity-based law: it damps the energy of the error instead of cancelling."""

from typing import NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import Law, model_terms, torque_of
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque


class SlidingVariable(NamedTuple):
    """The error as a first-order one, with the motion that would make it zero."""

    s: np.ndarray
    """e' + Lambda e = qd - v [rad/s]."""
    v: np.ndarray
    """qd* - Lambda e [rad/s]."""
    a: np.ndarray
    """qdd* - Lambda e' [rad/s^2]."""


def error_bandwidth(gains: Gains) -> np.ndarray:
    """Return Lambda = KD^-1 KP, with which -KD s = -KD e' - KP e, shape (6, 6) [1/s]."""
    return np.linalg.solve(gains.kd, gains.kp)


def sliding_variable(state: ArmState, reference: Reference,
                     bandwidth: np.ndarray) -> SlidingVariable:
    """Return s, v and a of a state."""
    v = reference.qd - bandwidth @ (state.q - reference.q)
    a = reference.qdd - bandwidth @ (state.qd - reference.qd)
    return SlidingVariable(state.qd - v, v, a)


class SlidingLaw(Law):
    """A law of the sliding variable."""

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._bandwidth = error_bandwidth(gains)

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse gains with which e'' + (KD + Lambda) e' + KP e = 0 is unstable when sampled."""
        super().check(Gains(gains.kp, gains.kd + error_bandwidth(gains)), parameters, arm,
                      control_rate)


def square_root(matrix: np.ndarray) -> np.ndarray:
    """Return the symmetric root of a symmetric positive definite matrix."""
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.sqrt(values)) @ vectors.T


class SlotineLi(SlidingLaw):
    r"""
    :math:`\tau = M a + C v + g - K s`, K = KD^1/2 M KD^1/2.

    Slotine and Li 1987, with :math:`s = \dot e + \Lambda e`, :math:`\Lambda = K_D^{-1} K_P`.
    K is positive definite and, as KP and KD of computed torque, weighed by M.

    """

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._root = square_root(gains.kd)

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque; ``coriolis`` is C v."""
        s, v, a = sliding_variable(state, reference, self._bandwidth)
        M, C, g = model_terms(state, self.arm)
        inertial = M @ reference.qdd
        feedback = M @ a - inertial - self._root @ M @ (self._root @ s)
        return torque_of(inertial, feedback, C @ v, g)
