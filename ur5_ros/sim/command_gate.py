"""
Which command acts, and when: lockstep and paced acceptance as a state machine without ROS.

The node reports to the gate what it published and received, and asks what to do next::

    gate = command_gate(joint_names, parameters, clock=time.monotonic)
    publish(state 1);  gate.published(1)
    loop:
        for each message on the two command topics:
            gate.offer(topic, stamp, effort)  # six torques in joint order; stamp 0 = unstamped
            gate.offer_by_name(topic, stamp, names, effort)           # any order, checked by name
        decision = gate.next()
        decision.step    -> plant.step(decision.command); publish; gate.published(plant.k)
                            (command None = the fallback)
        decision.resend  -> publish the present state once more, exactly as it was
        otherwise        -> wait for a message, at most until decision.wake (steady time; None =
                            without end)
    paused:              stop asking next(); offers go on; gate.resumed() when the pause ends.
                         ~/step while paused: ask next() until it steps once
    plant.reset():       publish; gate.was_reset(plant.k)
    two publishers:      gate.publishers({topic: [node names]}), now and then
    gate.drain_events()  -> events `lockstep`, `refused`, `publishers` for the bag and ~/events
    gate.refused, gate.accepted, gate.fired, gate.repeatable, gate.pacer.late ... for /diagnostics

``offer`` returns None if the command was taken, else why it was refused.  Nothing here raises on
account of a message.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import stamp_of_period
from ur5_ros.sim.command_validation import PublisherMonitor, in_joint_order, is_finite
from ur5_ros.sim.events import Event, event
from ur5_ros.sim.pacing import Pacer
from ur5_ros.throttle import RefusalCount


class Decision(NamedTuple):
    """What the node does next."""

    step: bool = False
    """Step now."""
    command: np.ndarray | None = None
    """With this; None = the fallback."""
    resend: bool = False
    """Publish the present state again."""
    wake: float | None = None
    """Ask again at this steady time at the latest [s]; None = when a message comes."""


class CommandGate(ABC):
    """
    Decides about commands; see the top of the file for its use.

    ``clock``: steady time [s].

    Attributes
    ----------
    accepted : int
        Commands taken.
    empty : int
        Messages whose torques are all NaN: no command yet.
    fired : int
        How often the lockstep timeout fired.
    repeatable : bool
        Whether the run may still claim to be repeatable.
    pacer : Pacer
        The schedule of paced periods.

    """

    def __init__(self, names: Sequence[str], parameters: SimParameters,
                 clock: Callable[[], float], factor: float):
        self._names = tuple(names)
        self._rate: int = parameters.control_rate
        self._clock = clock
        self.pacer = Pacer(self._rate, factor, clock)
        self.accepted, self.empty, self.fired, self.repeatable = 0, 0, 0, True
        self._refusals = RefusalCount(clock)
        self._events: list[Event] = []
        self._publishers = PublisherMonitor()
        self._answer: np.ndarray | None = None
        self.published(1)

    @property
    def refused(self) -> dict[tuple[str, str], int]:
        """Refusals by topic and reason."""
        return self._refusals.counts

    def published(self, k: int) -> None:
        """Take note that state ``k`` went out: from now on its answer is waited for."""
        self._k, self._stamp = k, stamp_of_period(k, self._rate)
        self._since = self._clock()

    def was_reset(self, k: int) -> None:
        """Take note that a reset published state ``k``; every command before it is forgotten."""
        self.published(k)
        self._answer = None
        self.pacer.start(k)

    def resumed(self) -> None:
        """Take note that a pause ended: timeout and schedule start again."""
        self._since = self._clock()
        self.pacer.start(self._k)

    @property
    def since(self) -> float:
        """Steady time at which the present state went out, or a pause after it ended [s]."""
        return self._since

    def offer_by_name(self, topic: str, stamp: int, names: Sequence[str],
                      effort: Sequence[float]) -> str | None:
        """Offer the torques of a JointState, its joints in any order; as :meth:`offer`."""
        command, reason = in_joint_order(self._names, names, effort)
        if command is None:
            return self._refuse(topic, reason)
        return self.offer(topic, stamp, command)

    def offer(self, topic: str, stamp: int, effort: Sequence[float] | np.ndarray) -> str | None:
        """
        Offer six torques in joint order [N m]; return why they were refused, None if taken.

        ``stamp`` is that of the state that they answer [ns], 0 where they have none.  An array of
        float64 is kept as it is.
        """
        command = np.asarray(effort, dtype=float)
        if command.shape != (6,):
            return self._refuse(topic, 'wrong number of torques')
        if not is_finite(command.tolist()):
            if np.isnan(command).all():
                self.empty += 1  # a hardware component of ros2_control before its first command
                return 'no torque'
            return self._refuse(topic, 'torque not finite')
        return self._offer(topic, stamp, command)

    @abstractmethod
    def _offer(self, topic: str, stamp: int, command: np.ndarray) -> str | None:
        """Take six finite torques, or return why not."""

    @abstractmethod
    def next(self) -> Decision:
        """Return what to do now."""

    def publishers(self, names: Mapping[str, Sequence[str]]) -> None:
        """Take note of the publishers on the command topics; more than one is an event."""
        several, event = self._publishers.update(names, self._stamp)
        self.repeatable = self.repeatable and not several
        if event is not None:
            self._events.append(event)

    def drain_events(self) -> list[Event]:
        """Return what is to be recorded since the last call."""
        events, self._events = self._events, []
        return events

    def _take(self, command: np.ndarray) -> None:
        self._answer = command
        self.accepted += 1

    def _early(self) -> Decision | None:
        """Return when to ask again where the paced period is not due yet."""
        due = self.pacer.due(self._k)
        return Decision(wake=due) if self._clock() < due else None

    def _refuse(self, topic: str, reason: str) -> str:
        if count := self._refusals.add(topic, reason):
            self._log('refused', f'{topic}: command refused: {reason} ({count} so far)',
                      topic=topic, reason=reason, count=count)
        return reason

    def _log(self, kind: str, message: str, /, **values: Any) -> None:
        self._events.append(event(self._stamp, kind, message, **values))
