"""Lockstep: simulated time stands still until the present state is answered."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import stamp_of_period
from ur5_ros.sim.command_gate import CommandGate, Decision
from ur5_ros.sim.paced_gate import PacedGate

#: The first unstamped command counts after this silence: late answers to copies of state 1 [s].
QUIET_TIME = 0.05
#: Copies of the first state are sent at this interval until a command counts [s].
RESEND_PERIOD = 0.1


def command_gate(names: Sequence[str], parameters: SimParameters,
                 clock: Callable[[], float]) -> CommandGate:
    """Return the gate that the parameters ask for."""
    gate = LockstepGate if parameters.lockstep else PacedGate
    return gate(names, parameters, clock)


class LockstepGate(CommandGate):
    """One command a state, and no step without it until the timeout fires."""

    def __init__(self, names: Sequence[str], parameters: SimParameters,
                 clock: Callable[[], float]):
        self._timeout: float = parameters.lockstep_timeout or math.inf
        self._candidate: np.ndarray | None = None
        self._candidate_at = 0.0
        self._started = False  # a command has counted
        self._running_on = False  # the timeout fired: the fallback acts, paced
        self._rearm = False  # ... until the present period is over
        self._quiet_rule = True  # the next unstamped command has to wait for silence
        super().__init__(names, parameters, clock, 1.0)

    def published(self, k: int) -> None:
        """Take note that state ``k`` went out; the command before it is forgotten."""
        super().published(k)
        self._sent = self._since
        self._answer = self._candidate = None

    def was_reset(self, k: int) -> None:
        """Take note of a reset; the next unstamped command has to wait for silence again."""
        super().was_reset(k)
        self._quiet_rule = True

    def _offer(self, topic: str, stamp: int, command: np.ndarray) -> str | None:
        if self._running_on:
            return self._offer_rearming(topic, stamp)
        if stamp != 0 and stamp != self._stamp:
            return self._refuse(topic, 'stamp of an earlier state' if stamp < self._stamp
                                else 'stamp of a state not yet published')
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
        if self._candidate is not None and self._answer is None:
            if self._clock() - self._candidate_at < QUIET_TIME:
                return Decision(wake=self._candidate_at + QUIET_TIME)
            self._quiet_rule = False
            self._take(self._candidate)
        if self._answer is not None:
            return Decision(True, self._answer)
        if not self._started:
            if self._clock() - self._sent >= RESEND_PERIOD:
                self._sent = self._clock()
                return Decision(resend=True, wake=self._sent + RESEND_PERIOD)
            return Decision(wake=self._sent + RESEND_PERIOD)
        if self._running_on:
            return self._run_on()
        if self._clock() - self._since >= self._timeout:
            self._fire()
            return Decision(True)
        return Decision(wake=None if math.isinf(self._timeout) else self._since + self._timeout)

    def _take(self, command: np.ndarray) -> None:
        super()._take(command)
        self._candidate, self._started = None, True

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
        if early := self._early():
            return early
        if self._rearm:
            self._running_on = self._rearm = False
            self._log('lockstep', 'a command came: the next state is waited for again',
                       fired=False, active=True)
        return Decision(True)
