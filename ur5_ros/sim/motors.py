"""The motors: which joint torque a command or a fallback becomes."""

from operator import le

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.friction import friction_compensation
from ur5_ros.sim.command_validation import is_finite
from ur5_ros.sim.event_log import EventLog
from ur5_ros.sim.fallback import fallback_torque
from ur5_ros.sim.integrator import NO_JOINTS
from ur5_ros.sim.mechanics import Mechanics
from ur5_ros.sim.torque_mode import TorqueMode


class Motors:
    """Torque within the limits of the arm, for one control period at a time."""

    def __init__(self, mechanics: Mechanics, parameters: SimParameters, log: EventLog):
        self._mechanics, self._log = mechanics, log
        self.torque_mode = TorqueMode(parameters, log)
        """Which commands act, and how much of them."""
        self._period = (parameters.physics_rate // parameters.control_rate
                        / parameters.physics_rate)
        self._excludes_gravity = parameters.effort_convention == 'gravity_excluded'
        self._strongest = np.array(mechanics.arm.limits.effort)
        self._strength = self._strongest.tolist()
        self.set_parameters(parameters)

    def set_parameters(self, parameters: SimParameters) -> None:
        """Let other parameters of the fallback and the friction compensation act."""
        self._fallback = parameters.fallback
        self._scales = (np.array(parameters.friction_compensation_viscous_scale),
                        np.array(parameters.friction_compensation_coulomb_scale))
        self._compensates = bool(np.any(self._scales))

    def read(self, command: np.ndarray) -> np.ndarray:
        """Return a command as six finite numbers."""
        command = np.array(command, dtype=float)
        if command.shape == (6,) and is_finite(command.tolist()):
            return command
        raise InputError(f'command {command.tolist()}; give six finite torques [N m]')

    def torque(self, command: np.ndarray | None, stamp: int,
               qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the torque that acts for a command [N m], and the joints where it was clamped.

        ``command`` (6,): as :meth:`read` returns it; None = the fallback; ``stamp``: of the
        present state [ns]; ``qd`` (6,): its measured velocities [rad/s].
        """
        log, mode, limited = self._log, self.torque_mode, NO_JOINTS
        if mode.matters:
            command = mode.admit(command, stamp)
        if command is None or log.stopped:
            return self._fall_back(stamp), NO_JOINTS
        if log.fallback:
            log.fall_back(stamp, '')
        if mode.matters:
            command, limited = mode.limit(command)
        effort, clamped = self._saturate(command, qd)
        return effort, clamped if limited is NO_JOINTS else clamped | limited

    def _saturate(self, command: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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

    def _fall_back(self, stamp: int) -> np.ndarray:
        """Return the torque of the fallback, or of the brake after a protective stop [N m]."""
        mechanics, log = self._mechanics, self._log
        mode = 'brake' if log.stopped else self._fallback
        log.fall_back(stamp, mode)
        log.counts['fallback_periods'] += 1
        return fallback_torque(mode, mechanics.bullet, mechanics.joints, mechanics.effects,
                               self._strongest, self._period)
