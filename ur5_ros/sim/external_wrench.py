"""The external wrench at the tool: in ``base``, until another comes or its time is over."""

import numpy as np


class ExternalWrench:
    """
    Force [N] and torque [N m] at the origin of ``tool0``.

    ``control_rate``: control periods a second [Hz].

    """

    def __init__(self, control_rate: int):
        self._rate = control_rate
        self.end: int | None = None
        """Control period in which its time is over."""
        self.value = np.zeros(6)
        """In ``base``, shape (6,)."""

    def set(self, wrench: np.ndarray, k: int, duration: float) -> None:
        """Let a wrench act from period ``k`` on, for a duration [s] above zero."""
        self.value = wrench + 0.0  # no negative zeros
        lasts = wrench.any() and duration > 0.0
        self.end = k + max(1, round(duration * self._rate)) if lasts else None
