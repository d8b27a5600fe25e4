"""What the encoders measure: the state, late and with noise, repeatable."""

from collections import deque

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


class Sensor:
    """Keeps the true states and measures the newest."""

    def __init__(self):
        self._noise = Noise()
        self._past: deque[tuple[int, ArmState]] = deque(maxlen=_KEPT)

    def clear(self) -> None:
        """Drop the past, as a reset does: a delayed state then shows the oldest one after it."""
        self._past.clear()

    def add(self, k: int, truth: ArmState) -> None:
        """Keep the true state of period ``k``."""
        self._past.append((k, truth))

    def measure(self, delay: int, position: float, velocity: float, seed: int) -> ArmState:
        """
        Return the newest state as it is measured.

        Parameters
        ----------
        delay : int
            Control periods between the measured state and the true one.
        position, velocity : float
            Standard deviations [rad], [rad/s].
        seed : int
            Key of the noise.

        Returns
        -------
        ArmState
            The stamp of the newest state with the content of ``delay`` periods before.

        """
        stamp = self._past[-1][1].stamp
        k, (_, q, qd, effort) = self._past[max(-1 - delay, -len(self._past))]
        if position > 0.0 or velocity > 0.0:
            noise = self._noise.of_period(seed, k)
            q, qd = q + position * noise[:6], qd + velocity * noise[6:]
        return ArmState(stamp, q, qd, effort)
