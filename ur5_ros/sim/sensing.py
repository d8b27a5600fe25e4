"""What the encoders tell: the state, late and with noise, the same for every order of asking."""

from collections import deque

import numpy as np

from ur5_ros.signals import ArmState

#: The longest delay that a parameter may ask for, plus the present state.
_KEPT = 1001


class Sensor:
    """
    Remembers the true states and tells the measured one.

    Noise is drawn from a counter-based generator keyed by the seed and the period, so that it
    depends on nothing else: not on what was asked before, nor on when noise was switched on.

    """

    def __init__(self):
        self._past: deque[tuple[int, ArmState]] = deque(maxlen=_KEPT)

    def forget(self) -> None:
        """Drop the past, as a reset does: a delayed state then shows the oldest one after it."""
        self._past.clear()

    def remember(self, k: int, truth: ArmState) -> None:
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
        now = self._past[-1][1]
        k, content = self._past[max(-1 - delay, -len(self._past))]
        q, qd = content.q, content.qd
        if position > 0.0 or velocity > 0.0:
            noise = np.random.Generator(
                np.random.Philox(key=seed, counter=[0, k, 0, 0])).standard_normal(12)
            q, qd = q + position * noise[:6], qd + velocity * noise[6:]
        return ArmState(now.stamp, q, qd, content.effort)
