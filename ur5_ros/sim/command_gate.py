"""
Which command acts, and when: lockstep and paced acceptance as a state machine without ROS.

The node reports to the gate what it published and received, and asks what to do next::

    gate = CommandGate(joint_names, parameters, clock=time.monotonic)
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

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import stamp_of_period
from ur5_ros.sim.command_validation import (
    PublisherMonitor,
    RefusalCount,
    in_joint_order,
    is_finite,
)
from ur5_ros.sim.events import Event, event
from ur5_ros.sim.pacing import Pacer

#: The first unstamped command counts after this silence: late answers to copies of state 1 [s].
QUIET = 0.05
#: Copies of the first state are sent at this interval until a command counts [s].
RESEND = 0.1


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


class CommandGate:
    """
    Decides about commands; see the top of the file for its use.

    Parameters
    ----------
    names : sequence of str
        The six joint names, prefix included.
    parameters : SimParameters
        Those of the simulator.
    clock : callable
        Steady time [s].

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
                 clock: Callable[[], float]):
        self._names = tuple(names)
        self._lockstep: bool = parameters.lockstep
        self._timeout: float = parameters.lockstep_timeout or math.inf
        self._rate: int = parameters.control_rate
        self._oldest = round(parameters.command_timeout * 1e9)
        self._clock = clock
        self.pacer = Pacer(self._rate, 1.0 if self._lockstep else parameters.realtime_factor,
                           clock)
        self.accepted, self.empty, self.fired, self.repeatable = 0, 0, 0, True
        self._longest_repeat = parameters.repeated_command_timeout * 1e9 or math.inf
        self._changed_stamp = 0
        self._refusals = RefusalCount(clock)
        self._events: list[Event] = []
        self._publishers = PublisherMonitor()
        self._answer: np.ndarray | None = None
        self._answer_stamp = 0
        self._candidate: np.ndarray | None = None
        self._candidate_at = 0.0
        self._started = False  # a command has counted
        self._running_on = False  # the timeout fired: the fallback acts, paced
        self._rearm = False  # ... until the present period is over
        self._quiet_rule = True  # the next unstamped command has to wait for silence
        self.published(1)

    @property
    def refused(self) -> dict[tuple[str, str], int]:
        """Refusals by topic and reason."""
        return self._refusals.counts

    def published(self, k: int) -> None:
        """Take note that state ``k`` went out: from now on its answer is waited for."""
        self._k, self._stamp = k, stamp_of_period(k, self._rate)
        self._since = self._sent = self._clock()
        if self._lockstep:
            self._forget()

    def was_reset(self, k: int) -> None:
        """Take note that a reset published state ``k``; every command before it is forgotten."""
        self.published(k)
        self._forget()
        self._quiet_rule = True
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
        """
        Offer the content of a JointState.

        Parameters
        ----------
        topic : str
            Where it came from, for the counters.
        stamp : int
            Stamp of the state that it answers [ns]; 0 = unstamped.
        names : sequence of str
            Joint names, in any order.
        effort : sequence of float
            Torques in the order of ``names`` [N m].

        Returns
        -------
        str or None
            None if it was taken, else why not.

        """
        command, reason = in_joint_order(self._names, names, effort)
        if command is None:
            return self._refuse(topic, reason)
        return self.offer(topic, stamp, command)

    def offer(self, topic: str, stamp: int, effort: Sequence[float] | np.ndarray) -> str | None:
        """Offer six torques in joint order; as :meth:`offer_by_name`."""
        command = np.array(effort, dtype=float)
        if command.shape != (6,):
            return self._refuse(topic, 'wrong number of torques')
        if not is_finite(command):
            if np.isnan(command).all():
                self.empty += 1  # a hardware component of ros2_control before its first command
                return 'no torque'
            return self._refuse(topic, 'torque not finite')
        if not self._lockstep:
            return self._offer_paced(topic, stamp, command)
        if stamp != 0 and stamp != self._stamp and not self._running_on:
            return self._refuse(topic, 'stamp of an earlier state' if stamp < self._stamp
                                else 'stamp of a state not yet published')
        if self._running_on:
            return self._offer_rearming(topic, stamp)
        if self._answer is not None:
            return self._refuse(topic, 'state already answered')
        if stamp == 0 and self._quiet_rule:
            if self._candidate is not None:
                self._refuse(topic, 'superseded before the first unstamped command counted')
            self._candidate, self._candidate_at = command, self._clock()
            return None
        self._take(command)
        return None

    def next(self) -> Decision:
        """Return what to do now."""
        if not self._lockstep:
            return self._next_paced()
        if self._candidate is not None and self._answer is None:
            if self._clock() - self._candidate_at < QUIET:
                return Decision(wake=self._candidate_at + QUIET)
            self._quiet_rule = False
            self._take(self._candidate)
        if self._answer is not None:
            return Decision(True, self._answer)
        if not self._started:
            if self._clock() - self._sent >= RESEND:
                self._sent = self._clock()
                return Decision(resend=True, wake=self._sent + RESEND)
            return Decision(wake=self._sent + RESEND)
        if self._running_on:
            return self._run_on()
        if self._clock() - self._since >= self._timeout:
            self._fire()
            return Decision(True)
        return Decision(wake=None if math.isinf(self._timeout) else self._since + self._timeout)

    def publishers(self, names: Mapping[str, Sequence[str]]) -> None:
        """Take note of the publishers on the command topics; more than one is an event."""
        several, event = self._publishers.look(names, self._stamp)
        self.repeatable = self.repeatable and not several
        if event is not None:
            self._events.append(event)

    def drain_events(self) -> list[Event]:
        """Return what is to be recorded since the last call."""
        events, self._events = self._events, []
        return events

    def _forget(self) -> None:
        self._answer, self._candidate, self._answer_stamp = None, None, 0

    def _take(self, command: np.ndarray) -> None:
        self._answer, self._candidate = command, None
        self._started = True
        self.accepted += 1

    def _fire(self) -> None:
        self.fired += 1
        self.repeatable = False
        self._running_on, self._rearm = True, False
        self.pacer.start(self._k)
        self._log('lockstep', f'no answer within {self._timeout:g} s of wall time: the simulator '
                   'runs on under the fallback; the run cannot be repeated', fired=True,
                   active=False)

    def _offer_rearming(self, topic: str, stamp: int) -> str | None:
        k = round(stamp * self._rate / 1e9)
        if stamp != 0 and not (1 <= k <= self._k and stamp_of_period(k, self._rate) == stamp):
            return self._refuse(topic, 'not a stamp of this run')
        if self._rearm:
            return self._refuse(topic, 'lockstep is about to resume')
        self._rearm = True
        self._quiet_rule = True
        return None

    def _run_on(self) -> Decision:
        due = self.pacer.due(self._k)
        if self._clock() < due:
            return Decision(wake=due)
        if self._rearm:
            self._running_on = self._rearm = False
            self._log('lockstep', 'a command came: the next state is waited for again',
                       fired=False, active=True)
        return Decision(True)

    def _offer_paced(self, topic: str, stamp: int, command: np.ndarray) -> str | None:
        stamp = stamp or self._stamp
        if stamp > self._stamp:
            return self._refuse(topic, 'stamp of a state not yet published')
        if self._stamp - stamp > self._oldest:
            return self._refuse(topic, 'older than command_timeout')
        if self._answer is not None and stamp < self._answer_stamp:
            return self._refuse(topic, 'older than the command that acts')
        if self._answer is None or (command != self._answer).any():
            self._changed_stamp = stamp
        elif stamp - self._changed_stamp > self._longest_repeat:
            return self._refuse(topic, 'the same torque for longer than '
                                'repeated_command_timeout')
        self._take(command)
        self._answer_stamp = stamp
        return None

    def _next_paced(self) -> Decision:
        due = self.pacer.due(self._k)
        if self._clock() < due:
            return Decision(wake=due)
        self.pacer.stepping(self._k)
        fresh = self._answer is not None and self._stamp - self._answer_stamp <= self._oldest
        return Decision(True, self._answer if fresh else None)

    def _refuse(self, topic: str, reason: str) -> str:
        refusal = self._refusals.add(topic, reason, self._stamp)
        if refusal is not None:
            self._events.append(refusal)
        return reason

    def _log(self, kind: str, message: str, /, **values: Any) -> None:
        self._events.append(event(self._stamp, kind, message, **values))
