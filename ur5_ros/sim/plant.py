"""The simulated arm with everything that a real one suffers from, one control period at a time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.worlds import EMPTY_WORLD, World, world_from
from ur5_ros.model.frames import wrench_in_base
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period
from ur5_ros.sim.command_delay import CommandDelay
from ur5_ros.sim.event_log import EventLog
from ur5_ros.sim.events import Event
from ur5_ros.sim.external_wrench import ExternalWrench
from ur5_ros.sim.integrator import NO_JOINTS
from ur5_ros.sim.limits import check_initial_state, check_rates
from ur5_ros.sim.mechanics import Mechanics
from ur5_ros.sim.motors import Motors
from ur5_ros.sim.payload import HeldPayload
from ur5_ros.sim.plant_parameters import PlantParameters
from ur5_ros.sim.sensing import Sensor
from ur5_ros.sim.world.contact_monitor import ContactMonitor


def plant_from_parameters(parameters: Mapping[str, Any] | SimParameters) -> 'Plant':
    """Return the plant that the parameters of the simulator describe."""
    parameters = SimParameters.of(parameters)
    return Plant(load_arm(parameters.arm), parameters)


class Plant:
    """
    The arm, its motors, its imperfections and its limits; no clock, no topic, no thread.

    The same commands give the same states to the last bit, in every process and whatever else
    runs.  :meth:`change`, :meth:`apply_wrench` and :meth:`reset` belong between steps.

    Parameters
    ----------
    arm : ArmParameters
        The arm to simulate.
    parameters : SimParameters or mapping, optional
        Values of ``SIM_PARAMETERS``; what is missing takes its default; ``arm`` is not read.

    Attributes
    ----------
    k : int
        Control period of the present state, counted from 1.
    stamp : int
        Stamp of the present state [ns].
    truth, state : ArmState
        The present state as it is, and as the encoders measure it.
    mechanics : Mechanics
        The moving body.
    exact_sensing : bool
        Whether ``state`` is ``truth``: no noise, no delay of states, the whole effort reported.

    Raises
    ------
    InputError
        If a parameter is refused, the rates do not fit, the arm cannot be simulated or starts
        beyond a stop.

    Examples
    --------
    >>> import numpy as np
    >>> from ur5_ros import Plant, gravity_torque, load_arm
    >>> arm = load_arm('ur5')
    >>> start = [0.0, -1.5, 1.5, 0.0, 0.5, 0.0]
    >>> plant = Plant(arm, {'control_rate': 500, 'initial_positions': start})
    >>> for _ in range(500):
    ...     state = plant.step(gravity_torque(plant.state.q, arm))
    >>> state.stamp, bool(np.abs(state.qd).max() < 1e-6)
    (1002000000, True)
    >>> plant.close()

    """

    def __init__(self, arm: ArmParameters,
                 parameters: Mapping[str, Any] | SimParameters | None = None):
        self.arm = arm
        self._plant_parameters = PlantParameters(SimParameters.of(parameters), arm)
        self.parameters = start = self._plant_parameters.parameters
        self._rate, physics_rate = start.control_rate, start.physics_rate
        check_rates(self._rate, physics_rate)
        check_initial_state(arm, start.initial_positions)
        self._substeps = physics_rate // self._rate
        self.mechanics = Mechanics(arm, 1.0 / physics_rate, start.gui, world_from(start))
        self._event_log = EventLog(arm)
        self._motors = Motors(self.mechanics, start, self._event_log)
        self._payload = HeldPayload(start)
        self._sensor = Sensor(start)
        self._delay = CommandDelay()
        self._contact_monitor = ContactMonitor(self._rate)
        self._wrench = ExternalWrench(self._rate)
        self.state: ArmState
        self.k = 0
        self._count_period()
        self._apply_parameters()
        self._start()
        if self.mechanics.world is not None:
            self.mechanics.world.refuse_overlap()

    @property
    def counters(self) -> dict[str, int]:
        """Return how often what happened."""
        return self._event_log.counters

    @property
    def stopped(self) -> bool:
        """Whether a protective stop is latched: the brake acts until :meth:`reset`."""
        return self._event_log.stopped

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
        InputError
            If the command is not six finite numbers.

        """
        if command is not None:
            command = self._motors.read(command)
        if self._something_due:
            command = self._take_due(command)
        self._delay.acting = command
        gravity = self.mechanics.declared_gravity() if self._sensor.excludes_gravity else None
        before = self.stamp
        effort, clamped = self._motors.torque(command, before, self.state.qd)
        moved = self.mechanics.advance(effort, self._substeps)
        self._count_period()
        self.truth = truth = ArmState(self.stamp, *self.mechanics.state(), effort)
        log = self._event_log
        if not moved.free or clamped is not NO_JOINTS or not log.limits.quiet:
            log.check_limits(before, truth, clamped, moved.held, self.parameters.overspeed_stop)
        if moved.failure:
            log.stop(self.stamp, JOINT_NAMES, f'{moved.failure}; the arm was put back at rest')
        if self.mechanics.contacts:
            self._check_contacts(before)
        self.state = self._sensor.measure(self.k, truth, gravity)
        return self.state

    def change(self, name: str, value: Any) -> None:
        """
        Change a parameter; it acts from the next step.

        Raises
        ------
        InputError
            If there is no such parameter, it cannot change while the plant runs, or the value
            is out of range.

        """
        value = self._plant_parameters.change(name, value)
        if name in ('payload.mass', 'payload.com', 'payload.inertia'):
            self._payload.change(self._plant_parameters.parameters, self.k)
        self._apply_parameters()
        self._log('parameter', f'{name} is {value}', name=name, value=value)

    def apply_wrench(self, force: Sequence[float], torque: Sequence[float],
                     frame: str = 'base') -> None:
        """
        Apply a wrench to the tool until the next call, or for a ``wrench_duration`` above zero.

        Parameters
        ----------
        force, torque : array_like, shape (3,)
            Force [N] and torque [N m] on the tool, at the origin of ``tool0``.
        frame : str
            Their axes: ``base``, ``base_link``, or ``tool0`` as it stands now.

        Raises
        ------
        InputError
            If the frame is another or a number is not finite.

        """
        self._wrench.set(wrench_in_base(force, torque, frame, self.truth.q, self.arm), self.k,
                         self.parameters.wrench_duration)
        self._apply_parameters()
        wrench = self._wrench.value.tolist()
        self._log('wrench', f'wrench at the tool {wrench}', force=wrench[:3], torque=wrench[3:],
                  frame='base')

    def reset(self) -> ArmState:
        """Return the initial state under the next stamp; commands under way are dropped."""
        self._count_period()
        self._event_log.stopped = False
        self._event_log.counts['resets'] += 1
        self._delay.clear()
        self._sensor.clear()
        self.mechanics.reset_world()
        self._contact_monitor.clear()
        self._motors.torque_mode.resume()
        self._start()
        self._log('reset', 'back at the initial state', position=self.truth.q.tolist(),
                   velocity=self.truth.qd.tolist())
        return self.state

    @property
    def world(self) -> World:
        """What stands around the arm."""
        return EMPTY_WORLD if self.mechanics.world is None else self.mechanics.world.world

    def contact_effort(self) -> list[tuple[int, np.ndarray]]:
        """Return stamp [ns] and joint torque of all contacts [N m], a row a physics step."""
        rate, first = self._rate * self._substeps, (self.k - 1) * self._substeps
        return [(stamp_of_period(first + i + 1, rate), np.array(each.torque))
                for i, each in enumerate(self.mechanics.contacts)]

    def tool_wrench(self) -> np.ndarray:
        """
        Return what acts on the tool: contacts and the external wrench, at and in ``tool0``.

        Returns
        -------
        numpy.ndarray, shape (6,)
            Force [N] and torque [N m], the mean of the last control period.

        """
        from ur5_ros.sim.world.tool_wrench import tool_wrench  # loads Numba
        return tool_wrench(self.mechanics.contacts, self._wrench.value, self.truth.q, self.arm)

    def resume_torque_mode(self) -> str:
        """Let commands act again after silence ended torque mode; return what to answer."""
        if self.stopped:
            return 'a protective stop is latched; call ~/reset'
        return self._motors.torque_mode.resume()

    def drain_events(self) -> list[Event]:
        """Return what happened since the last call, in the order in which it did."""
        return self._event_log.drain()

    def close(self) -> None:
        """Leave PyBullet."""
        self.mechanics.bullet.close()

    def _count_period(self) -> None:
        self.k += 1
        self.stamp = stamp_of_period(self.k, self._rate)

    def _check_contacts(self, before: int) -> None:
        """Report contacts that begin or end, and stop the arm where the force is too large."""
        for message, values in self._contact_monitor.update(self.mechanics.contacts):
            self._event_log.add(before, 'contact', message, **values)
        limit = self.parameters.force_limit
        if limit > 0.0 and not self.stopped:
            size = float(np.linalg.norm(self.tool_wrench()[:3]))
            if size > limit:
                self._event_log.stop(self.stamp, JOINT_NAMES, f'{size:.4g} N on the tool, above '
                                     f'force_limit {limit:g} N')

    def _start(self) -> None:
        self.mechanics.place(self.parameters.initial_positions,
                             self.parameters.initial_velocities)
        self.truth = ArmState(self.stamp, *self.mechanics.state(), np.zeros(6))
        self.state = self._sensor.measure(self.k, self.truth)

    def _apply_parameters(self) -> None:
        """Let the present parameters act: what they decide is decided here, not in a step."""
        given = self.parameters = self._plant_parameters.parameters
        self.mechanics.set_payload(self._payload.load, given.gravity)
        self.mechanics.set_effects(self._plant_parameters.effects(self._wrench.value))
        self._sensor.set_parameters(given)
        self._motors.set_parameters(given)
        self.exact_sensing = self._sensor.exact
        self._look_ahead()

    def _look_ahead(self) -> None:
        """Note whether :meth:`_take_due` has to be asked in the next period."""
        self._something_due = (self._wrench.end is not None or self._payload.changing
                               or self.parameters.delay_command_periods > 0 or self._delay.busy)

    def _take_due(self, command: np.ndarray | None) -> np.ndarray | None:
        """End a wrench, take a stage of the payload; return the command that arrives now."""
        if self.k == self._wrench.end:
            self.apply_wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        if self._payload.take_stage(self.k):
            self._apply_parameters()
            self._log('payload', f'payload of {self._payload.load.mass:g} kg',
                      **self._payload.load._asdict())
        if self.parameters.delay_command_periods > 0 or self._delay.busy:
            command = self._delay.exchange(self.k, command, self.parameters.delay_command_periods)
        self._look_ahead()
        return command

    def _log(self, kind: str, message: str, /, **values: Any) -> None:
        self._event_log.add(self.stamp, kind, message, **values)
