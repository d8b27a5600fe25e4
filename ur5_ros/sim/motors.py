"""The motors: which joint torque a command or a fallback becomes."""

from operator import le

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.friction import friction_compensation
from ur5_ros.sim.command_validation import is_finite
from ur5_ros.sim.fallback import fallback_torque
from ur5_ros.sim.integrator import NO_JOINTS
from ur5_ros.sim.mechanics import Mechanics


class Motors:
    """Torque within the limits of the arm, for one control period at a time."""

    def __init__(self, mechanics: Mechanics, parameters: SimParameters):
        self._mechanics = mechanics
        self._period = (parameters.physics_rate // parameters.control_rate
                        / parameters.physics_rate)
        self._excludes_gravity = parameters.effort_convention == 'gravity_excluded'
        self._strongest = np.array(mechanics.arm.limits.effort)
        self._strength = self._strongest.tolist()
        self.set_parameters(parameters)

    def set_parameters(self, parameters: SimParameters) -> None:
        """Let other parameters of the friction compensation act."""
        self._scales = (np.array(parameters.friction_compensation_viscous_scale),
                        np.array(parameters.friction_compensation_coulomb_scale))
        self._compensates = bool(np.any(self._scales))

    def read(self, command: np.ndarray) -> np.ndarray:
        """Return a command as six finite numbers."""
        command = np.array(command, dtype=float)
        if command.shape == (6,) and is_finite(command.tolist()):
            return command
        raise InputError(f'command {command.tolist()}; give six finite torques [N m]')

    def saturate(self, command: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the torque that six finite ones become [N m], and the joints where it was clamped.

        g(q) is added where commands exclude it, and what the robot adds against its friction at
        the measured velocities [rad/s].
        """
        if self._excludes_gravity:
            command = command + self._mechanics.declared_gravity()
        if self._compensates:
            command = command + friction_compensation(self._mechanics.effects.friction, qd,
                                                      *self._scales)
        if all(map(le, map(abs, command.tolist()), self._strength)):
            return command, NO_JOINTS
        effort = np.minimum(np.maximum(command, -self._strongest), self._strongest)
        return effort, effort != command

    def fall_back(self, mode: str) -> np.ndarray:
        """Return the torque of a fallback [N m]."""
        mechanics = self._mechanics
        return fallback_torque(mode, mechanics.bullet, mechanics.joints, mechanics.effects,
                               self._strongest, self._period)
