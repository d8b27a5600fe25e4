"""Paced: a period begins when its time has come, with the newest command that is young enough."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.sim.command_gate import CommandGate, Decision


class PacedGate(CommandGate):
    """A command acts until the next one, and for ``command_timeout`` at most."""

    def __init__(self, names: Sequence[str], parameters: SimParameters,
                 clock: Callable[[], float]):
        self._oldest = round(parameters.command_timeout * 1e9)
        self._longest_repeat = parameters.repeated_command_timeout * 1e9 or math.inf
        self._answer_stamp = self._changed_stamp = 0
        super().__init__(names, parameters, clock, parameters.realtime_factor)

    def was_reset(self, k: int) -> None:
        """Take note of a reset: every command before it is forgotten."""
        super().was_reset(k)
        self._answer_stamp = 0

    def _offer(self, topic: str, stamp: int, command: np.ndarray) -> str | None:
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

    def next(self) -> Decision:
        """Return what to do now."""
        if early := self._early():
            return early
        self.pacer.stepping(self._k)
        fresh = self._answer is not None and self._stamp - self._answer_stamp <= self._oldest
        return Decision(True, self._answer if fresh else None)
