"""The motors: which joint torque a command or a fallback becomes."""

from math import isfinite
from operator import le

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.sim.fallback import fallback_torque
from ur5_ros.sim.integrator import NO_JOINTS
from ur5_ros.sim.mechanics import Mechanics


class Motors:
    """
    Torque within the limits of the arm, for one control period at a time.

    Parameters
    ----------
    mechanics : Mechanics
        What they move.
    period : float
        Control period [s].
    excludes_gravity : bool
        Commands leave gravity to the arm: g(q) of its record and declared payload is added.

    """

    def __init__(self, mechanics: Mechanics, period: float, excludes_gravity: bool):
        self._mechanics = mechanics
        self._period = period
        self._excludes_gravity = excludes_gravity
        self._strongest = np.array(mechanics.arm.limits.effort)
        self._strength = self._strongest.tolist()

    def read(self, command: np.ndarray) -> np.ndarray:
        """
        Return a command as six finite numbers.

        Raises
        ------
        InputError
            If it is something else.

        """
        command = np.asarray(command, dtype=float)
        if command.shape == (6,) and all(map(isfinite, command.tolist())):
            return command
        raise InputError(f'command {command.tolist()}; give six finite torques [N m]')

    def saturate(self, command: np.ndarray,
                 compensation: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the torque that a command becomes and the joints where it was clamped.

        Parameters
        ----------
        command : numpy.ndarray, shape (6,)
            Six finite torques [N m].
        compensation : numpy.ndarray, shape (6,), optional
            What the robot adds against its friction [N m].

        """
        if self._excludes_gravity:
            command = command + self._mechanics.declared_gravity()
        if compensation is not None:
            command = command + compensation
        if all(map(le, map(abs, command.tolist()), self._strength)):
            return command.copy(), NO_JOINTS
        effort = np.minimum(np.maximum(command, -self._strongest), self._strongest)
        return effort, effort != command

    def fall_back(self, mode: str) -> np.ndarray:
        """Return the torque of a fallback [N m]."""
        mechanics = self._mechanics
        return fallback_torque(mode, mechanics.bullet, mechanics.joints, mechanics.effects,
                               self._strongest, self._period)
