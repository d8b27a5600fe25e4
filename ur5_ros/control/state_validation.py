"""Validation of states: a clock or an arm that jumps must not move the reference."""

from enum import Enum

import numpy as np

from ur5_ros.control.computed_torque import LARGEST_STATE
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import Limits
from ur5_ros.signals import ArmState

#: Simulated time without a state after which motions do not go on [ns].
CLOCK_GAP = 1_000_000_000
#: Implausible states answered in a row; after that the robot's own watchdog acts.
MOST_IMPLAUSIBLE = 10


class StateStatus(Enum):
    """What a state is, after the one before it."""

    FOLLOWS = 'follows'
    FIRST = 'first state'
    RESTARTED = 'clock went back'
    GAP = 'clock jumped ahead'
    MOVED = 'arm was moved'
    IMPLAUSIBLE = 'implausible'


class StateValidator:
    """Compares each state with the last accepted one."""

    def __init__(self) -> None:
        self.last: ArmState | None = None
        """The last accepted state."""
        self.sentence = ''
        """Why the last state that did not just follow was special."""
        self._suspect: ArmState | None = None
        self._run = 0

    def validate(self, state: ArmState, largest_jump: float) -> StateStatus:
        """
        Return the status of a state; remember the state if it is accepted.

        A state in which a joint jumps is not accepted; when the next state confirms the new place,
        the arm was moved (a reset of the simulator).

        ``largest_jump``: how far a joint may move between two states [rad].  Returned: all but
        IMPLAUSIBLE make ``state`` the last accepted one.
        """
        last = self.last
        if not sum(map(abs, [*state.q.tolist(), *state.qd.tolist()])) < LARGEST_STATE:  # or NaN
            return self._reject(state, 'the state holds a number not finite or beyond any joint')
        if last is None:
            return self.accept(state, StateStatus.FIRST)
        step = state.stamp - last.stamp
        if step < 0:
            self.sentence = f'the clock went back by {-step / 1e9:.6f} s'
            return self.accept(state, StateStatus.RESTARTED)
        if step > CLOCK_GAP:
            self.sentence = f'the clock jumped ahead by {step / 1e9:.6f} s'
            return self.accept(state, StateStatus.GAP)
        jump = float(np.abs(state.q - last.q).max())
        if jump <= largest_jump:
            return self.accept(state, StateStatus.FOLLOWS)
        suspect = self._suspect
        if suspect is not None and np.abs(state.q - suspect.q).max() <= largest_jump:
            return self.accept(state, StateStatus.MOVED)
        joint = int(np.abs(state.q - last.q).argmax())
        status = self._reject(state, f'joint {joint + 1} jumped by {jump:.4f} rad between two '
                              f'states; max_state_jump is {largest_jump:g}')
        self._suspect = state
        return status

    def predecessor(self, stamp: int) -> ArmState | None:
        """Return the last accepted state if a state with this stamp [ns] follows it at once."""
        last = self.last
        return last if last is not None and 0 <= stamp - last.stamp <= CLOCK_GAP else None

    def accept(self, state: ArmState, status: StateStatus) -> StateStatus:
        """Remember a state as the last accepted one; return ``status``."""
        self.last, self._suspect, self._run = state, None, 0
        return status

    def _reject(self, state: ArmState, sentence: str) -> StateStatus:
        self.sentence = sentence
        self._run += 1
        if self.last is None or self._run > MOST_IMPLAUSIBLE:
            raise InputError(f'{sentence} at stamp {state.stamp} ns; not answered')
        return StateStatus.IMPLAUSIBLE


def joint_beyond(state: ArmState, limits: Limits) -> int | None:
    """Return the first joint beyond a limit in position or speed; None if all are within."""
    within = ((limits.lower <= state.q) & (state.q <= limits.upper)
              & (np.abs(state.qd) <= limits.velocity))
    return None if within.all() else int(within.argmin())
