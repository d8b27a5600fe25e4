"""PID: three gains a joint and no model of the arm."""

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains, definite_matrix
from ur5_ros.control.laws.law import Law, torque_of
from ur5_ros.control.laws.stability import check_integral, home_inertia
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

_ZERO = np.zeros(6)


class ErrorIntegral:
    """The integral of the position error; it stands still while a torque limit acts."""

    def __init__(self, effort_limit: np.ndarray) -> None:
        self._limit = effort_limit
        self.reset()

    def reset(self) -> None:
        """Begin at zero."""
        self.value, self.total = np.zeros(6), np.zeros(6)

    def add(self, error: np.ndarray, dt: float) -> np.ndarray:
        """Return the integral up to a state [rad s]."""
        free = np.abs(self.total) <= self._limit  # else it would wind up
        self.value = self.value + dt * np.where(free, error, 0.0)
        return self.value


class IntegralLaw(Law):
    """A law with the gain ``ki`` on the integral of the error."""

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._ki = definite_matrix('ki', parameters.ki)
        self._integral = ErrorIntegral(arm.limits.effort)

    def reset(self) -> None:
        """Forget the integral."""
        self._integral.reset()

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse gains that are unstable, in continuous time or sampled."""
        super().check(gains, parameters, arm, control_rate)
        inertia = np.eye(6) if cls.weighed else home_inertia(arm)
        check_integral(parameters.mode, gains, definite_matrix('ki', parameters.ki), inertia,
                       control_rate)


class PID(IntegralLaw):
    r"""
    :math:`\tau = -K_P e - K_D \dot e - K_I \int e\,dt`.

    Arimoto and Miyazaki 1984.  Promise: an arm that comes to rest has no position error,
    whatever gravity, payload and constant forces are: the integral carries them.

    """

    weighed = False

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque; all of it is feedback."""
        error, kp, kd = state.q - reference.q, *self.gains
        integral = self._integral.add(error, dt)
        feedback = -kp @ error - kd @ (state.qd - reference.qd) - self._ki @ integral
        self._integral.total = feedback
        return torque_of(_ZERO, feedback, _ZERO, _ZERO)
