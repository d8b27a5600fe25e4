"""The moving body: PyBullet, what is added to it, the stops, one physics step at a time."""

from collections.abc import Sequence
from operator import le

import numpy as np

from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.integrator import NO_JOINTS, Effects, Joints, PlantIntegrator
from ur5_ros.sim.payload import loaded_arm

#: Beyond this a state is not believed: no arm moves so fast or turns so far [rad, rad/s].
_RUNAWAY = 1e6


class Mechanics:
    """
    Joint state and what moves it.

    Parameters
    ----------
    arm : ArmParameters
        The arm.
    step_time : float
        Length h of a physics step [s].
    gui : bool
        Open PyBullet's window.

    """

    def __init__(self, arm: ArmParameters, step_time: float, gui: bool):
        self.arm = arm
        self.step_time = step_time
        self.bullet = BulletArm(arm, arm.gravity, step_time, gui)
        limits = arm.limits
        self._least = np.concatenate([limits.lower, -limits.velocity]).tolist()
        self._most = np.concatenate([limits.upper, limits.velocity]).tolist()
        self._load = (0.0, [0.0, 0.0, 0.0], arm.gravity.tolist())
        self._now: tuple[float, ...] = (0.0,) * 12

    @property
    def joints(self) -> Joints:
        """Positions [rad] and velocities [rad/s]."""
        return Joints([*self._now[:6]], [*self._now[6:]])

    def set_payload(self, mass: float, com: list[float], gravity: list[float]) -> None:
        """
        Load the tool with a further point mass and set gravity; the joint state stays.

        Parameters
        ----------
        mass : float
            Mass that the arm record does not declare [kg].
        com : list of float
            Where, in ``tool0`` [m].
        gravity : list of float
            In ``base`` [m/s^2]; empty = the arm's.

        """
        load = (mass, list(com), list(gravity) or self.arm.gravity.tolist())
        if load != self._load:
            self._load = load
            self.bullet.load(loaded_arm(self.arm, mass, com), load[2])
            self.bullet.place(*self.joints)

    def act(self, effects: Effects) -> None:
        """Set what acts beside the bodies, gravity and the motors."""
        self.effects = effects
        self._scheme = PlantIntegrator(effects, self.step_time)
        self.plain = self._scheme.none

    def place(self, q: Sequence[float], qd: Sequence[float]) -> None:
        """Put the joints there."""
        self._now = (*q, *qd)
        self.bullet.place(*self.joints)

    def advance(self, effort: np.ndarray, tau: list[float]) -> tuple[np.ndarray, bool, np.ndarray]:
        """
        Take one physics step.

        Parameters
        ----------
        effort : numpy.ndarray, shape (6,)
            Torque of the motors [N m].
        tau : list of float
            The same as a list.

        Returns
        -------
        values : numpy.ndarray, shape (12,)
            q [rad], qd [rad/s].
        ordinary : bool
            Whether no limit of position or velocity is in sight.
        held : numpy.ndarray, shape (6,), bool
            The joints that a stop held back.

        Raises
        ------
        FloatingPointError
            If the state ran away; the arm then rests where it was before the step.

        """
        before, held = self._now, NO_JOINTS
        if not self.plain:
            tau, held = self._scheme.engine_torque(self.bullet, self.joints, effort)
        now = self._now = self.bullet.advance(tau)
        if all(map(le, self._least, now)) and all(map(le, now, self._most)):  # no NaN is
            return np.array(now), held is NO_JOINTS, held
        values = np.array(now)
        if self.plain and self._beyond_a_stop(values):  # PyBullet has none: step back, again
            self.place(before[:6], before[6:])
            torque, held = self._scheme.engine_torque(self.bullet, self.joints, effort)
            self._now = self.bullet.advance(torque)
            values = self.values()
        if not np.abs(values).max() < _RUNAWAY:  # NaN is not less either
            self.place(before[:6], [0.0] * 6)
            raise FloatingPointError('the state of the arm ran away')
        return values, False, held

    def advance_plainly(self, tau: Sequence[float], steps: int) -> tuple[float, ...] | None:
        """Take steps under the motors alone; None, and nothing taken, where a limit is passed."""
        before, advance = self._now, self.bullet.advance
        for _ in range(steps):
            now = advance(tau)
            if not (all(map(le, self._least, now)) and all(map(le, now, self._most))):
                self.bullet.place(before[:6], before[6:])
                return None
        self._now = now
        return now

    def _beyond_a_stop(self, values: np.ndarray) -> bool:
        q, limits = values[:6], self.arm.limits
        beyond = (q < limits.lower) | (q > limits.upper)
        return bool(beyond.any() and np.abs(values).max() < _RUNAWAY)

    def values(self) -> np.ndarray:
        """Return q and qd in one array, shape (12,)."""
        return np.array(self._now)

    def declared_gravity(self) -> np.ndarray:
        """Return g(q) of the arm record and its declared payload, in its own gravity [N m]."""
        mass, com, gravity = self._load
        own = self.arm.gravity.tolist()
        if gravity != own:
            self.bullet.set_gravity(own)
        tau = self.bullet.bias(self.joints.q)
        if gravity != own:
            self.bullet.set_gravity(gravity)
        if mass > 0.0:
            tau = tau + mass * (self.bullet.jacobian(self.joints.q, com)[:3].T @ self.arm.gravity)
        return tau
