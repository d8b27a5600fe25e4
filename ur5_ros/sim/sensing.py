"""What is measured: the state, late and with noise, and the effort as the drives report it."""

from collections import deque

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import ArmState

#: The longest delay that a parameter may ask for, plus the present state.
_KEPT_STATES = 1001


class Noise:
    """
    Standard normal numbers of a period, from a counter-based generator.

    Keyed by the seed and the period, they depend on nothing else: not on what was asked before,
    nor on when noise was switched on.

    """

    def __init__(self):
        self._bits = np.random.Philox(key=0)
        self._numbers = np.random.Generator(self._bits)
        self._fresh = self._bits.state  # put back before each use: a new generator takes longer

    def of_period(self, seed: int, k: int) -> np.ndarray:
        """Return six numbers for the positions and six for the velocities of period ``k``."""
        place = self._fresh['state']
        place['key'][0], place['counter'][1] = seed, k
        self._bits.state = self._fresh
        return self._numbers.standard_normal(12)


class Sensor:
    """Keeps the true states and measures the newest, by the parameters in force."""

    def __init__(self, parameters: SimParameters):
        self._noise = Noise()
        self._past: deque[tuple[int, ArmState]] = deque(maxlen=_KEPT_STATES)
        self.set_parameters(parameters)

    def set_parameters(self, parameters: SimParameters) -> None:
        """Let other parameters act."""
        self._delay, self._seed = parameters.delay_state_periods, parameters.seed
        self._position, self._velocity = parameters.noise_position, parameters.noise_velocity
        self._plain = not (self._delay or self._position or self._velocity)
        self._feedback = parameters.effort_feedback
        self._torque_constant = np.array(parameters.torque_constant)
        self.exact = self._plain and self._feedback == 'total'
        """Whether what is measured is the true state."""
        self.excludes_gravity = self._feedback == 'gravity_excluded'
        """Whether the drives report the torque without what gravity takes."""

    def clear(self) -> None:
        """Drop the past, as a reset does: a delayed state then shows the oldest one after it."""
        self._past.clear()

    def measure(self, k: int, truth: ArmState, gravity: np.ndarray | None = None) -> ArmState:
        """
        Return the state of period ``k`` as it is measured: its stamp, content of before.

        ``gravity`` (6,): what the drives leave out of the torque that they report [N m].
        """
        if gravity is not None:
            truth = truth._replace(effort=truth.effort - gravity)
        elif self._feedback == 'current':
            truth = truth._replace(effort=truth.effort / self._torque_constant)
        self._past.append((k, truth))
        if self._plain:
            return truth
        k, (_, q, qd, effort) = self._past[max(-1 - self._delay, -len(self._past))]
        if self._position > 0.0 or self._velocity > 0.0:
            noise = self._noise.of_period(self._seed, k)
            q, qd = q + self._position * noise[:6], qd + self._velocity * noise[6:]
        return ArmState(truth.stamp, q, qd, effort)
