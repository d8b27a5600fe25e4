"""The plant of an ordinary run, without arrays a period: the bits of Plant, short of a limit."""

import struct
import threading
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.control import kernel
from ur5_ros.control.computed_torque import TorqueLaw
from ur5_ros.control.kernel import TOTAL
from ur5_ros.control.settings import Settings
from ur5_ros.control.takeover import START_DISTANCE
from ur5_ros.loop.run_config import RunConfig
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference, stamp_of_period
from ur5_ros.sim.bullet_arm import BulletArm, Joints
from ur5_ros.sim.event_log import EventLog
from ur5_ros.sim.events import Event
from ur5_ros.sim.fallback import fallback_torque
from ur5_ros.sim.integrator import NO_JOINTS, PlantIntegrator
from ur5_ros.sim.payload import loaded_arm, tool_load
from ur5_ros.sim.plant_parameters import PlantParameters
from ur5_ros.sim.sensing import Noise

#: Bodies loaded into one world; PyBullet forgets some four thousand bytes of each.
_MOST_LOADS = 200

_here = threading.local()
_write = struct.Struct('12d').pack_into
_ROW = 12 * 8  # bytes of q, qd


class Rollout(NamedTuple):
    """A run of n periods."""

    states: np.ndarray
    """q, qd at the beginning and after every physics step, 12 columns."""
    late: np.ndarray
    """The period whose state was measured in each period, counted from 0, shape (n,)."""
    measured: np.ndarray
    """q, qd as the encoders measured them, shape (n, 12)."""
    effort: np.ndarray
    """What acted from each period to the next [N m], shape (n - 1, 6)."""
    torque: np.ndarray
    """The law's answers with their parts [N m], shape (n, 5, 6)."""
    events: tuple[Event, ...]


class RolloutEngine:
    """An arm at its initial state, for one run."""

    def __init__(self, config: RunConfig, arm: ArmParameters) -> None:
        self._sim, self._arm, self._periods = config.sim, arm, config.periods
        self._substeps = config.sim.physics_rate // config.sim.control_rate
        self._delay = min(config.sim.delay_command_periods, config.periods - 1)
        self._effects = PlantParameters(config.sim, arm).effects(np.zeros(6))
        integrator = PlantIntegrator(self._effects, 1.0 / config.sim.physics_rate)
        self._integrator = None if integrator.none else integrator

    def run(self, settings: Settings, table: Reference) -> Rollout | None:
        """Return the run, or None where plant or law have more to do than a period's equations."""
        periods, delay, law = self._periods, self._delay, settings.joint_law()
        states = np.empty(((periods - 1) * self._substeps + 1, 12))
        states[0] = [*self._sim.initial_positions, *self._sim.initial_velocities]
        measured = _MeasuredStates(self._sim, states[::self._substeps])
        if np.abs(measured.first[:6] - table.q[0]).max() > START_DISTANCE:
            return None
        torque, effort = np.empty((periods, 5, 6)), np.empty((periods - 1, 6))
        try:
            if not self._simulate(law, table, states, measured, torque, effort):
                return None
        except ArithmeticError:
            return None
        effort[delay:] = torque[:periods - 1 - delay, TOTAL]
        return Rollout(states, measured.late, measured.measured(), effort, torque, self._events())

    def _simulate(self, law: TorqueLaw, table: Reference, states: np.ndarray,
                  measured: '_MeasuredStates', torque: np.ndarray, effort: np.ndarray) -> bool:
        """Fill the arrays, the effort while no command acts; return whether no check applied."""
        bullet, integrator = self._world(), self._integrator
        delay, last = self._delay, self._periods - 1
        advance, answer, substeps = bullet.stepper(), kernel.law.single, range(self._substeps)
        given, commands = (np.zeros(6), np.inf, *law.constants), torque[:, TOTAL]
        at, before = 0, None
        values, page = tuple(states[0].tolist()), states.data.cast('B')
        for k, (row, true, noise, desired, out) in enumerate(
                zip(*measured.rows(), zip(*table, strict=True), torque, strict=True)):
            if noise is not None:
                np.add(true, noise, out=row)
            q = row[:6]
            if answer(q, row[6:], q if before is None else before, *desired, *given, out):
                return False
            if k == last:
                break
            before = q
            if k < delay:
                effort[k] = acting = self._fall_back(bullet, values)
            else:
                acting = commands[k - delay]
            tau = acting.tolist()
            for _ in substeps:
                if integrator is not None:
                    tau, held = integrator.engine_torque(bullet, values, acting)
                    if held is not NO_JOINTS:
                        return False
                values = advance(tau)
                at += _ROW
                _write(page, at, *values)
        return True

    def _fall_back(self, bullet: BulletArm, values: tuple[float, ...]) -> np.ndarray:
        """Return the torque of a period in which no command has come yet [N m]."""
        return fallback_torque(self._sim.fallback, bullet, Joints(values[:6], values[6:]),
                               self._effects, np.array(self._arm.limits.effort),
                               self._substeps / self._sim.physics_rate)

    def _events(self) -> tuple[Event, ...]:
        """Return the events: a fallback until the first command arrives."""
        log, rate = EventLog(self._arm), self._sim.control_rate
        if self._delay > 0:
            log.fall_back(stamp_of_period(1, rate), self._sim.fallback)
        if 0 < self._delay < self._periods - 1:
            log.fall_back(stamp_of_period(self._delay + 1, rate), '')
        return tuple(log.drain())

    def _world(self) -> BulletArm:
        """Return this thread's world with the bodies in it, at the initial state."""
        sim = self._sim
        gravity = sim.gravity or self._arm.gravity.tolist()
        load = sim.arm, tool_load(sim), gravity
        bullet, loaded, rate, loads = getattr(_here, 'world', (None, None, None, 0))
        if bullet is None or rate != sim.physics_rate or loaded != load:
            _here.world = (None, None, None, 0)
            arm = loaded_arm(self._arm, *tool_load(sim))
            if bullet is not None and rate == sim.physics_rate and loads < _MOST_LOADS:
                bullet.load(arm, gravity)  # opening a world takes longer
            else:
                if bullet is not None:
                    bullet.close()
                bullet, loads = BulletArm(arm, np.array(gravity), 1.0 / sim.physics_rate), 0
            _here.world = bullet, load, sim.physics_rate, loads + 1
        bullet.place(sim.initial_positions, sim.initial_velocities)
        return bullet


class _MeasuredStates:
    """The states as the encoders measure them: some periods late, with noise, or exact."""

    def __init__(self, sim: SimParameters, states: np.ndarray) -> None:
        self._states, delay = states, sim.delay_state_periods
        periods = np.arange(len(states))
        self.late = np.maximum(periods - delay, 0) if delay else periods
        spread = np.repeat([sim.noise_position, sim.noise_velocity], 6)
        self._noise: np.ndarray | None = None
        self._measured = np.empty((0, 12))
        self.first = states[0]
        if spread.any():
            draw, seed = Noise().of_period, sim.seed
            self._noise = spread * np.array([draw(seed, k + 1) for k in self.late.tolist()])
            self._measured = np.empty_like(self._noise)
            self.first = states[0] + self._noise[0]

    def rows(self) -> tuple[Iterable, Iterable, Iterable]:
        """Return measured row, state and noise of each period; the row is the state without."""
        true = list(self._states)
        true = [true[k] for k in self.late.tolist()]
        if self._noise is None:
            return true, true, [None] * len(true)
        return self._measured, true, self._noise

    def measured(self) -> np.ndarray:
        """Return the measured q, qd, shape (n, 12)."""
        return self._states[self.late] if self._noise is None else self._measured
