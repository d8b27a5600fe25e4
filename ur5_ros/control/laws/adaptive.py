"""Slotine and Li's adaptive law: it learns the base parameters of the arm while it moves."""

from functools import lru_cache

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import model_terms, torque_of
from ur5_ros.control.laws.slotine_li import (
    SlidingLaw,
    sliding_variable,
    square_root,
)
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import (
    BaseParameters,
    base_parameters,
    dynamics_regressor,
    inertial_parameters,
)
from ur5_ros.signals import ArmState, Reference, Torque

_ZERO = np.zeros(6)
#: States over which the adaptation gain is scaled.
_STATES = 64


class Adaptive(SlidingLaw):
    r"""
    :math:`\tau = Y \hat\pi - K s`, :math:`\dot{\hat\pi} = -\Gamma Y^T s`.

    Slotine and Li 1987, with :math:`s = \dot e + \Lambda e`, :math:`\Lambda = K_D^{-1} K_P`;
    Y(q, qd, v, a) pi = M a + C v + g in the base parameters, K = KD^1/2 M_0 KD^1/2 with the M of
    the arm file.  Gamma is diagonal: a unit of each parameter counts by the acceleration that it
    makes, so that ``adaptation_rate`` is the square of a frequency.  Promise:
    :math:`V = \frac12 s^T M s + \frac12 \tilde\pi^T \Gamma^{-1} \tilde\pi` falls,
    :math:`\dot V = -s^T K s`, whatever the masses are; the tracking error goes to zero, the
    parameters go to the true ones only where the motion shows them.

    """

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._root = square_root(gains.kd)
        self._base, scale = _structure(_Key(arm))
        self.adaptation = parameters.adaptation_rate * scale
        """Diagonal of Gamma, shape (b,)."""
        self.estimate = self._base.combination @ inertial_parameters(arm)
        """Base parameters as they are estimated now, shape (b,)."""

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse gains or an adaptation that are unstable when sampled."""
        super().check(gains, parameters, arm, control_rate)
        fastest = float(np.linalg.eigvalsh(gains.kd).max()) / control_rate
        most = (4.0 - 2.0 * fastest) * control_rate**2 / _structure(_Key(arm))[0].columns.size
        if parameters.adaptation_rate >= most:
            raise InputError(f'adaptation_rate is {parameters.adaptation_rate:g}; sampled at '
                             f'{control_rate} Hz give less than {most:.4g} 1/s^2')

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque of the estimated parameters, after learning from s."""
        s, v, a = sliding_variable(state, reference, self._bandwidth)
        inertial, coriolis, gravity = self._regressors(state, v, a)
        regressor = inertial + coriolis + gravity
        self.estimate = self.estimate - dt * self.adaptation * (regressor.T @ s)
        M = model_terms(state, self.arm)[0]
        rotors = self.arm.armature * a  # known: not part of the parameters
        feedback = -self._root @ M @ (self._root @ s)
        return torque_of(inertial @ self.estimate + rotors, feedback, coriolis @ self.estimate,
                         gravity @ self.estimate)

    def _regressors(self, state: ArmState, v: np.ndarray, a: np.ndarray) -> tuple[
            np.ndarray, np.ndarray, np.ndarray]:
        """Return what multiplies the base parameters in M a, C v and g, each (6, b)."""
        q, qd = state.q + self.arm.angle_offset, state.qd
        # C(q, qd) v is bilinear in the speeds: a quarter of h(qd + v) - h(qd - v)
        speeds = np.array([_ZERO, _ZERO, qd + v, qd - v])
        rest, moved, fast, slow = dynamics_regressor(
            q, speeds, np.array([_ZERO, a, _ZERO, _ZERO]), self.arm)[..., self._base.columns]
        return moved - rest, 0.25 * (fast - slow), rest


class _Key:
    """An arm as a key: equal where what the regressor reads is equal."""

    def __init__(self, arm: ArmParameters) -> None:
        self.arm, self._bytes = arm, arm.constants.tobytes() + arm.angle_offset.tobytes()

    def __hash__(self) -> int:
        return hash(self._bytes)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self._bytes == other._bytes


@lru_cache(maxsize=8)
def _structure(key: _Key) -> tuple[BaseParameters, np.ndarray]:
    """Return the base parameters and 1 / mean of Y_j^T M^-1 Y_j over spread states, (b,)."""
    arm = key.arm
    base = base_parameters(arm)
    spread = np.random.default_rng(1).uniform(-1.0, 1.0, (3, _STATES, 6))
    q, qd, qdd = np.pi * spread[0], spread[1], 2.0 * spread[2]
    y = dynamics_regressor(q, qd, qdd, arm)[..., base.columns]
    weighed = np.linalg.solve(inertia_matrix(q, arm), y)
    return base, 1.0 / np.einsum('nij,nij->nj', y, weighed).mean(axis=0)
