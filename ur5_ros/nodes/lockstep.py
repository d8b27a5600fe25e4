"""Lockstep: simulated time stands still until the answer to a state has come."""

import time
from typing import NamedTuple

from ur5_ros.nodes.sim_inputs import SimInputs
from ur5_ros.nodes.simulation import Simulation

#: A state without an answer is sent again after this wall time [s].
RESEND = 0.1
#: Longest wait before signals and services are looked at [s].
GLANCE = 0.05


class Refused(NamedTuple):
    kind: str
    reason: str


class InterimGate:
    def __init__(self, timeout):
        self.timeout = timeout
        self.stamp = 0
        self.answered = False
        self.first = True

    def state_sent(self, stamp, now):
        self.stamp = stamp
        self.answered = False

    def offer(self, stamp):
        if self.answered:
            return Refused('surplus', 'answered already')
        if stamp and stamp != self.stamp:
            return Refused('stamp', f'stamp {stamp} is not that of the state waited for, {self.stamp}')
        self.answered = True
        self.first = False
        return None

    def copy_sent(self, now):
        pass

    def hold(self, now):
        pass

    def timed_out(self, now):
        return False

    may_resend = True


class Lockstep:
    """
    Takes a period whenever the gate has let a command through.

    Parameters
    ----------
    simulation : Simulation
        The plant on its topics.
    inputs : SimInputs
        Commands, wrenches, requests.

    """

    def __init__(self, simulation: Simulation, inputs: SimInputs) -> None:
        self._simulation = simulation
        self._inputs = inputs
        self._gate = inputs.gate
        self._sent = time.monotonic()

    def begin(self) -> None:
        """Send state 1."""
        self._simulation.begin()
        self._state_is_out()

    def turn(self) -> None:
        """Wait a moment and take a period if its command has come."""
        inputs, simulation = self._inputs, self._simulation
        k = simulation.plant.k
        inputs.receive(GLANCE)
        if simulation.plant.k != k:  # a reset
            self._state_is_out()
        command = inputs.command
        if command is not None:
            if simulation.may_step:
                inputs.command = None
                simulation.advance(command)
                self._state_is_out()
        else:
            self._look_at_the_clock()

    def _state_is_out(self) -> None:
        self._sent = time.monotonic()
        self._inputs.command = None
        self._gate.state_sent(self._simulation.plant.stamp, self._sent)

    def _look_at_the_clock(self) -> None:
        now = time.monotonic()
        simulation = self._simulation
        if not simulation.may_step:
            self._gate.hold(now)
        elif now - self._sent >= RESEND and self._gate.may_resend:
            self._sent = now
            simulation.outputs.state_again()
            self._gate.copy_sent(now)
