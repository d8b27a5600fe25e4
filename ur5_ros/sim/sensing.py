"""What the encoders tell: the state, late and with noise, the same for every order of asking."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from ur5_ros.signals import ArmState

#: The longest delay that a parameter may ask for, plus the present state.
_KEPT = 1001


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


class Snapshot:
    """
    A true state as PyBullet gave it; it becomes arrays when somebody asks.

    Parameters
    ----------
    stamp : int
        Simulated time [ns].
    values : array_like, shape (12,)
        Six positions [rad], six velocities [rad/s].
    effort : array_like, shape (6,)
        Six torques [N m].

    """

    __slots__ = ('_effort', '_stamp', '_state', '_values')

    def __init__(self, stamp: int, values: Sequence[float] | np.ndarray,
                 effort: Sequence[float] | np.ndarray):
        self._stamp, self._values, self._effort = stamp, values, effort
        self._state: ArmState | None = None

    def __call__(self) -> ArmState:
        """Return the state."""
        if self._state is None:
            values = np.array(self._values)
            self._state = ArmState(self._stamp, values[:6], values[6:], np.array(self._effort))
        return self._state


class Sensor:
    """Remembers the true states and tells the measured one."""

    def __init__(self):
        self._noise = Noise()
        self._past: deque[tuple[int, Snapshot]] = deque(maxlen=_KEPT)

    def forget(self) -> None:
        """Drop the past, as a reset does: a delayed state then shows the oldest one after it."""
        self._past.clear()

    def remember(self, k: int, truth: Snapshot) -> None:
        """Keep the true state of period ``k``."""
        self._past.append((k, truth))

    def measured(self, delay: int, position: float, velocity: float, seed: int) -> ArmState:
        """
        Return the newest state as it is told.

        Parameters
        ----------
        delay : int
            Control periods between what is told and the truth.
        position, velocity : float
            Standard deviations [rad], [rad/s].
        seed : int
            Key of the noise.

        Returns
        -------
        ArmState
            The stamp of the newest state with the content of ``delay`` periods before.

        """
        now = self._past[-1][1]()
        k, past = self._past[max(-1 - delay, -len(self._past))]
        content = past()
        q, qd = content.q, content.qd
        if position > 0.0 or velocity > 0.0:
            noise = self._noise.of_period(seed, k)
            q, qd = q + position * noise[:6], qd + velocity * noise[6:]
        return ArmState(now.stamp, q, qd, content.effort)
