"""The simulated arm with everything that a real one suffers from, one control period at a time."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.config.parameters import SIM_PARAMETERS, check
from ur5_ros.errors import Refusal
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period
from ur5_ros.sim.command_delay import CommandDelay
from ur5_ros.sim.events import Event, event
from ur5_ros.sim.fallback import fallback_torque
from ur5_ros.sim.limits import LimitWatch, check_initial_state, check_rates
from ur5_ros.sim.mechanics import Mechanics
from ur5_ros.sim.scheme import Effects
from ur5_ros.sim.sensing import Sensor

_PARAMETERS = {parameter.name: parameter for parameter in SIM_PARAMETERS}
_NOBODY = np.zeros(6, dtype=bool)


def plant_from_parameters(parameters: Mapping[str, Any]) -> 'Plant':
    """
    Return the plant that the parameters of the simulator describe.

    Parameters
    ----------
    parameters : mapping
        A value for every parameter, as :func:`ur5_ros.config.complete` gives.

    Raises
    ------
    Refusal
        As :func:`ur5_ros.config.load_arm` and :class:`Plant`.

    """
    return Plant(load_arm(parameters['arm']), parameters)


class Plant:
    """
    The arm, its motors, its imperfections and its limits; no clock, no topic, no thread.

    The same commands give the same states to the last bit, in every process and whatever else
    runs.  :meth:`change`, :meth:`apply_wrench` and :meth:`reset` belong between steps.

    Parameters
    ----------
    arm : ArmParameters
        The arm to simulate.
    parameters : mapping
        A value for every parameter of ``SIM_PARAMETERS``; ``arm`` among them is not read.

    Attributes
    ----------
    k : int
        Control period of the present state, counted from 1.
    state, truth : ArmState
        The present state as the encoders tell it, and as it is.
    stopped : bool
        Whether a protective stop is latched: the brake acts until :meth:`reset`.
    counters : dict of str to int
        How often what happened.

    Raises
    ------
    Refusal
        If the rates do not fit, the arm cannot be simulated or starts beyond a stop.

    """

    def __init__(self, arm: ArmParameters, parameters: Mapping[str, Any]):
        self.arm = arm
        self.parameters = dict(parameters)
        self._rate, physics_rate = self.parameters['control_rate'], self.parameters['physics_rate']
        check_rates(self._rate, physics_rate)
        check_initial_state(arm, self.parameters['initial_positions'])
        self._substeps = physics_rate // self._rate
        self._period = self._substeps / physics_rate
        self._strongest = np.array(arm.limits.effort)
        self._weakest = -self._strongest
        self._excludes_gravity = self.parameters['effort_convention'] == 'gravity_excluded'
        self._wrench = np.zeros(6)
        self._wrench_end: int | None = None
        self._events: list[Event] = []
        self._fallback_active = False
        self._watch = LimitWatch()
        self._sensor = Sensor()
        self._delay = CommandDelay()
        self.counters = {'fallback_periods': 0, 'protective_stops': 0, 'resets': 0}
        self.k = 1
        self.stopped = False
        self._mechanics = Mechanics(arm, 1.0 / physics_rate, self.parameters['gui'])
        self._settle()
        self._start()

    @property
    def stamp(self) -> int:
        """Stamp of the present state [ns]."""
        return stamp_of_period(self.k, self._rate)

    def step(self, command: np.ndarray | None) -> ArmState:
        """
        Advance one control period.

        Parameters
        ----------
        command : numpy.ndarray, shape (6,), or None
            Joint torques in the effort convention of the parameters [N m]; None = the fallback.

        Returns
        -------
        ArmState
            The measured state of the next period; its effort acted from the one before.

        Raises
        ------
        Refusal
            If the command is not six finite numbers.

        """
        if command is not None:
            command = np.asarray(command, dtype=float)
            if command.shape != (6,) or not math.isfinite(sum(command.tolist())):
                raise Refusal(f'command {command.tolist()}; give six finite torques [N m]')
        k = self.k
        if k == self._wrench_end:
            self.apply_wrench(np.zeros(3), np.zeros(3))
        command = self._delay.exchange(k, command, self.parameters['delay.command_periods'])
        if command is None or self.stopped:
            effort, clamped = self._fall_back(), _NOBODY
        else:
            effort, clamped = self._obey(command)
        tau, held, ran_away = effort.tolist(), _NOBODY, False
        for _ in range(self._substeps):
            try:
                values, ordinary, at_stop = self._mechanics.advance(effort, tau)
            except FloatingPointError:
                values, ordinary, ran_away = self._mechanics.values(), False, True
                break
            if at_stop is not held:
                held = held | at_stop
        self.k = k + 1
        stamp = stamp_of_period(k + 1, self._rate)
        self.truth = ArmState(stamp, values[:6], values[6:], effort)
        if not ordinary or clamped is not _NOBODY or not self._watch.quiet:
            self._look_at_limits(k, clamped, held)
        if ran_away:
            self._stop(JOINT_NAMES, 'the state ran away and was put back at rest')
        return self._sense()

    def change(self, name: str, value: Any) -> None:
        """
        Change a parameter; it acts from the next step.

        Raises
        ------
        Refusal
            If there is no such parameter, it cannot change while the plant runs, or the value
            is out of range.

        """
        parameter = _PARAMETERS.get(name)
        if parameter is None or not parameter.live:
            names = ', '.join(known for known, p in _PARAMETERS.items() if p.live)
            what = 'is no parameter' if parameter is None else 'cannot change during a run'
            raise Refusal(f'{name} {what}; these can: {names}')
        value = check(parameter, value)
        self.parameters[name] = value
        self._settle()
        self._tell('parameter', f'{name} is {value}', name=name, value=value)

    def apply_wrench(self, force: np.ndarray, torque: np.ndarray, frame: str = 'base') -> None:
        """
        Push the tool: until the next call, or for ``wrench_duration`` if that is not zero.

        Parameters
        ----------
        force, torque : array_like, shape (3,)
            Force [N] and torque [N m] on the tool, at the origin of ``tool0``.
        frame : str
            ``base`` or ``base_link``: the axes that they are given in.

        Raises
        ------
        Refusal
            If the frame is another or a number is not finite.

        """
        wrench = np.concatenate([np.asarray(force, dtype=float), np.asarray(torque, dtype=float)])
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            raise Refusal(f'wrench {wrench.tolist()}; give three finite numbers each [N], [N m]')
        if frame not in ('base', 'base_link'):
            raise Refusal(f'wrench in frame {frame!r}; give base or base_link')
        if frame == 'base_link':
            wrench *= [-1.0, -1.0, 1.0, -1.0, -1.0, 1.0]  # base = base_link turned by Rz(pi)
        self._wrench = wrench + 0.0
        duration = self.parameters['wrench_duration']
        lasts = wrench.any() and duration > 0.0
        self._wrench_end = self.k + max(1, round(duration * self._rate)) if lasts else None
        self._settle()
        self._tell('wrench', f'wrench at the tool {self._wrench.tolist()}',
                   force=self._wrench[:3].tolist(), torque=self._wrench[3:].tolist(), frame='base')

    def reset(self) -> ArmState:
        """Return the initial state under the next stamp; commands under way are dropped."""
        self.k += 1
        self.stopped = False
        self.counters['resets'] += 1
        self._delay.clear()
        self._sensor.forget()
        self._start()
        self._tell('reset', 'back at the initial state', position=self.truth.q.tolist(),
                   velocity=self.truth.qd.tolist())
        return self.state

    def drain_events(self) -> list[Event]:
        """Return what happened since the last call, in the order in which it did."""
        events, self._events = self._events, []
        return events

    def close(self) -> None:
        """Leave PyBullet."""
        self._mechanics.bullet.close()

    def _start(self) -> None:
        self._mechanics.place(self.parameters['initial_positions'],
                              self.parameters['initial_velocities'])
        values = self._mechanics.values()
        self.truth = ArmState(self.stamp, values[:6], values[6:], np.zeros(6))
        self._sense()

    def _settle(self) -> None:
        """Let the present parameters act."""
        given, limits = self.parameters, self.arm.limits
        self._mechanics.hang(given['payload.mass'], given['payload.com'], given['gravity'])
        self._mechanics.act(Effects(
            self.arm.armature, np.array(given['friction.viscous']),
            np.array(given['friction.coulomb']), self._wrench, limits.lower, limits.upper))
        self._sensing = (given['delay.state_periods'], given['noise.position'],
                         given['noise.velocity'], given['seed'])
        self.exact_sensing = not any(self._sensing[:3])

    def _sense(self) -> ArmState:
        self._sensor.remember(self.k, self.truth)
        self.state = self.truth if self.exact_sensing else self._sensor.measured(*self._sensing)
        return self.state

    def _obey(self, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the torque of the motors and the joints where the limit clamped it."""
        if self._fallback_active:
            self._tell_fallback(False)
        if self._excludes_gravity:
            command = command + self._mechanics.declared_gravity(self._mechanics.joints.q)
        effort = np.minimum(np.maximum(command, self._weakest), self._strongest)
        return effort, _NOBODY if effort.tolist() == command.tolist() else effort != command

    def _fall_back(self) -> np.ndarray:
        if not self._fallback_active:
            self._tell_fallback(True)
        self.counters['fallback_periods'] += 1
        mode = 'brake' if self.stopped else self.parameters['fallback']
        return fallback_torque(mode, self._mechanics.bullet, self._mechanics.joints,
                               self._mechanics.effects, self._strongest, self._period)

    def _look_at_limits(self, k: int, clamped: np.ndarray, held: np.ndarray) -> None:
        """Tell who began or ceased to touch a limit in the step from ``k``."""
        before, after = stamp_of_period(k, self._rate), self.truth.stamp
        fast = np.abs(self.truth.qd) > self.arm.limits.velocity
        for kind, mask, stamp in (('effort', clamped, before), ('position', held, before),
                                  ('velocity', fast, after)):
            told = self._watch.look(kind, mask, stamp)
            if told is not None:
                self._events.append(told)
        if fast.any() and self.parameters['overspeed_stop'] and not self.stopped:
            self._stop([JOINT_NAMES[i] for i in np.flatnonzero(fast)], 'over-speed')

    def _stop(self, joints: list[str], why: str) -> None:
        self.stopped = True
        self.counters['protective_stops'] += 1
        self._tell('protective_stop', f'protective stop: {why}; the brake acts until a reset',
                   joints=list(joints))

    def _tell_fallback(self, active: bool) -> None:
        self._fallback_active = active
        mode = 'brake' if self.stopped else self.parameters['fallback']
        self._tell('fallback', f'{mode} {"acts" if active else "gives way to a command"}',
                   mode=mode, active=active)

    def _tell(self, kind: str, message: str, /, **values: Any) -> None:
        self._events.append(event(self.stamp, kind, message, **values))
