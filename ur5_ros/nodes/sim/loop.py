"""The simulator's loop: receive, ask the gate, step."""

import time

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.nodes.sim.inputs import SimInputs
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.sim.command_gate import CommandGate, Decision

#: Longest wait before signals and services are looked at [s].
POLL_PERIOD = 0.05
#: What to do while paused: wait.
PAUSED = Decision()
#: In lockstep a state whose stamped answer stays away is sent again after this wall time [s]: our
#: subscriptions are best effort, and a lost message must not cost a timeout.
RESEND_PERIOD = 0.1


class SimLoop:
    """
    Turns of the loop: one period, one copy, or one wait each.

    ``parameters``: ``lockstep``: whether time waits for commands; ``lockstep_timeout``: how long
    [s].

    """

    def __init__(self, simulation: Simulation, inputs: SimInputs, gate: CommandGate,
                 parameters: SimParameters) -> None:
        self._simulation = simulation
        self._inputs = inputs
        self._gate = gate
        self._lockstep = parameters.lockstep
        self._longest_wait = min(POLL_PERIOD, parameters.lockstep_timeout or POLL_PERIOD)
        self._wait = 0.0
        self._reminded = 0.0

    def begin(self) -> None:
        """Send state 1."""
        self._simulation.begin()
        self._gate.published(1)
        self._gate.resumed()

    def turn(self) -> bool:
        """Receive what has come or comes within the wait, then take a period if one is due."""
        simulation, gate = self._simulation, self._gate
        received = self._inputs.receive(self._wait)
        decision = gate.next() if simulation.may_step else PAUSED
        if decision.step:
            simulation.advance(decision.command)
            gate.published(simulation.plant.k)
            self._inputs.answer_step()
        elif decision.resend or (not received and self._answer_may_be_lost()):
            simulation.outputs.introduce_again()
            simulation.outputs.state_again()
        self._wait = self._time_to_wait(decision)
        simulation.send_events(gate)
        return received or decision.step

    def _time_to_wait(self, decision: Decision) -> float:
        """Return the longest wait [s] for the next message."""
        if decision.step:
            return self._longest_wait if self._lockstep and decision.command is not None else 0.0
        if decision.wake is None:
            return POLL_PERIOD
        return min(max(decision.wake - time.monotonic(), 0.0), POLL_PERIOD)

    def _answer_may_be_lost(self) -> bool:
        """Return whether the state should be sent again, as its stamped answer stays away."""
        now = time.monotonic()
        sent = max(self._gate.since, self._reminded)
        if not (self._lockstep and self._simulation.may_step and self._inputs.last_was_stamped
                and now - sent >= RESEND_PERIOD):
            return False
        self._reminded = now
        return True
