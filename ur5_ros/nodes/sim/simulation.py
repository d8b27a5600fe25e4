"""The plant on its topics, one period at a time."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.nodes.sim.topics import SimOutputs
from ur5_ros.signals import ArmState
from ur5_ros.sim.command_gate import CommandGate
from ur5_ros.sim.events import Event, event
from ur5_ros.sim.plant import Plant
from ur5_ros.throttle import Throttle

if TYPE_CHECKING:
    from ur5_ros.sim.world.publication import ContactPublication

#: Simulated time in which the arm is brought to rest when the node is asked to end [s].
BRAKING_TIME = 0.2
#: Joint speed that counts as rest [rad/s].
REST_SPEED = 1e-3

#: Kinds of event that are warnings in the log.
_WARNINGS = ('limit', 'protective_stop', 'publishers', 'refused')
#: Kinds that describe what holds from now on: the last line in the log is the present one.
_STATES = ('fallback', 'lockstep')


class Simulation:
    """Steps the plant and publishes its states and events."""

    def __init__(
        self, plant: Plant, outputs: SimOutputs, logger: Any, parameters: SimParameters,
    ) -> None:
        self.plant = plant
        self.outputs = outputs
        self.logger = logger
        self.paused = False
        self.stopped = False
        """Whether it is paused in its initial state, not to be stepped, by the standard."""
        self.steps_requested = 0
        """Periods to take while paused."""
        rate = parameters.control_rate
        self.period = 1.0 / rate
        """Control period [s]."""
        self._last = round(parameters.stop_after * rate) or None
        self._throttle = Throttle()
        self._present: dict[str, Event] = {}
        self._logged: dict[str, str] = {}
        self._contact = None if plant.world.empty else _publication(parameters)

    @property
    def finished(self) -> bool:
        """Whether the last state of ``stop_after`` is out."""
        return self._last is not None and self.plant.k >= self._last

    @property
    def may_step(self) -> bool:
        """Whether time may go on: not paused, or a single step is requested."""
        return not self.paused or self.steps_requested > 0

    def begin(self) -> None:
        """Send state 1."""
        self._send(self.plant.state)

    def advance(self, command: np.ndarray | None) -> None:
        """
        Take one control period and send the state at its end.

        ``command`` (6,): torques [N m]; None = the fallback.
        """
        self._send(self.plant.step(command))
        if self.steps_requested:
            self.steps_requested -= 1

    def reset(self) -> str:
        """Put the arm back; return what to answer."""
        self._send(self.plant.reset())
        return f'state {self.plant.k} is the initial one'

    def zero_force_torque_sensor(self) -> str:
        """Take the wrench of now for zero; return what to answer."""
        if self._contact is None:
            raise InputError('there is no force sensor without a world; set the parameter world')
        self._contact.zero(self.plant)
        self.log('force_torque_sensor', 'zeroed')
        return 'the present wrench is the new zero'

    def pause(self, paused: bool) -> str:
        """Stop or let go simulated time; return what to answer."""
        word = 'paused' if paused else 'running'
        if paused == self.paused:
            return f'{word} already'
        self.paused = paused
        self.log('pause', word, active=paused)
        return word

    def log(self, kind: str, message: str, **values: Any) -> None:
        """Send an event that acts from the present state."""
        self._send_event(event(self.plant.stamp, kind, message, **values))

    def rest(self) -> None:
        """Bring the arm to rest under the fallback."""
        for _ in range(max(1, round(BRAKING_TIME / self.period))):
            if np.abs(self.plant.truth.qd).max() <= REST_SPEED:
                break
            self.advance(None)

    def send_events(self, source: Plant | CommandGate) -> None:
        """Send the events of the plant or the gate."""
        for each in source.drain_events():
            self._send_event(each)

    def _send(self, state: ArmState) -> None:
        self.outputs.state(state)
        if not self.plant.exact_sensing:
            self.outputs.truth(self.plant.truth)
        if self._contact is not None:
            self.outputs.contact(self._contact.messages(self.plant))
        self.send_events(self.plant)

    def log_present(self) -> None:
        """Log what holds now, at most once a second of each kind."""
        for kind, each in self._present.items():
            if each.message != self._logged.get(kind) and self._throttle(kind):
                skipped = self._throttle.skipped(kind)
                more = f'; {skipped} changes since the last line' if skipped else ''
                self.logger.warning(f'{each.message} ({each.stamp * 1e-9:.3f} s){more}')
                self._logged[kind] = each.message

    def _send_event(self, each: Event) -> None:
        self.outputs.event(each)
        if each.kind in _STATES:
            self._present[each.kind] = each
            self.log_present()
        kind = each.kind if each.kind == 'limit' else each.kind + each.values.get(
            'reason', each.message)
        if each.kind in _WARNINGS and self._throttle(kind):
            skipped = self._throttle.skipped(kind)
            more = f'; {skipped} more events "{each.kind}" since the last line' if skipped else ''
            self.logger.warning(f'{each.message} ({each.stamp * 1e-9:.3f} s){more}')


def _publication(parameters: SimParameters) -> 'ContactPublication':
    from ur5_ros.sim.world.publication import ContactPublication  # loads Numba
    return ContactPublication(parameters)
