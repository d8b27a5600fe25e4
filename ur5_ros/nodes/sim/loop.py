"""The simulator's loop: ask the gate, step or wait, hear what has come."""

import time
from collections.abc import Mapping
from typing import Any

from ur5_ros.nodes.sim.inputs import SimInputs
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.sim.command_gate import CommandGate

#: Longest wait before signals and services are looked at [s].
POLL_PERIOD = 0.05
#: In lockstep a state whose stamped answer stays away is sent again after this wall time [s]: our
#: subscriptions are best effort, and a lost message must not cost a timeout.
RESEND = 0.1


class SimLoop:
    """
    Turns of the loop: one period, one copy, or one wait each.

    Parameters
    ----------
    simulation : Simulation
        The plant on its topics.
    inputs : SimInputs
        What is heard.
    gate : CommandGate
        Decides which command acts, and when.
    parameters : mapping
        ``lockstep``: whether time waits for commands; ``lockstep_timeout``: how long [s].

    """

    def __init__(self, simulation: Simulation, inputs: SimInputs, gate: CommandGate,
                 parameters: Mapping[str, Any]) -> None:
        self._simulation = simulation
        self._inputs = inputs
        self._gate = gate
        self._lockstep = parameters['lockstep']
        self._patience = min(POLL_PERIOD, parameters['lockstep_timeout'] or POLL_PERIOD)
        self._reminded = 0.0

    def begin(self) -> None:
        """Send state 1."""
        self._simulation.begin()
        self._gate.published(1)
        self._gate.resumed()

    def turn(self) -> None:
        """Take a period, or wait a moment for what lets it be taken."""
        simulation, inputs, gate = self._simulation, self._inputs, self._gate
        if not simulation.may_step:
            inputs.receive(POLL_PERIOD)
            simulation.send_events(gate)
            return
        if inputs.stepped:  # a plain period has just gone out: there is nothing to decide
            inputs.stepped = False
            inputs.receive(self._patience)
            simulation.send_events(gate)
            return
        decision = gate.next()
        if decision.step:
            simulation.advance(decision.command)
            gate.published(simulation.plant.k)
            inputs.answer_step()
            if not self._lockstep or decision.command is None:
                inputs.poll()
        elif decision.resend:
            simulation.outputs.state_again()
        else:
            wake = decision.wake
            rest = POLL_PERIOD if wake is None else wake - time.monotonic()
            if not inputs.receive(min(max(rest, 0.0), POLL_PERIOD)) and self._lockstep:
                self._remind()
        simulation.send_events(gate)

    def _remind(self) -> None:
        """Send the state again if its answer may have been lost."""
        now = time.monotonic()
        sent = max(self._gate.since, self._reminded)
        if self._inputs.last_was_stamped and now - sent >= RESEND:
            self._reminded = now
            self._simulation.outputs.state_again()
