"""Simulated time against wall time: when the next period is due, and how late periods were."""

from collections.abc import Callable

#: Further behind than this the schedule starts again: no burst makes up for a stopped process [s].
_LOST_SCHEDULE = 0.2


class Pacer:
    """
    A schedule of control periods on a steady clock.

    ``control_rate``: control periods per simulated second [Hz]; ``factor``: simulated per wall
    time; 0 = as fast as it goes; ``clock``: steady time [s].

    Attributes
    ----------
    late : int
        Periods that began more than half a period after they were due.
    worst : float
        The longest such delay [s].
    lost : float
        Wall time by which the schedule was moved because a period was 0.2 s late or more [s].

    """

    def __init__(self, control_rate: int, factor: float, clock: Callable[[], float]):
        self._period = 1.0 / (control_rate * factor) if factor > 0.0 else 0.0
        self._clock = clock
        self.late, self.worst, self.lost = 0, 0.0, 0.0
        self.start(1)

    def start(self, k: int) -> None:
        """Let period ``k`` begin now, and the others follow; after a pause, for instance."""
        self._k, self._origin = k, self._clock()

    def due(self, k: int) -> float:
        """Return the time at which the step from state ``k`` is due [s]."""
        return self._origin + (k + 1 - self._k) * self._period

    def stepping(self, k: int) -> None:
        """Take note that the step from state ``k`` is made now."""
        if self._period == 0.0:
            return
        behind = self._clock() - self.due(k)
        if behind > 0.5 * self._period:
            self.late += 1
            self.worst = max(self.worst, behind)
        if behind > _LOST_SCHEDULE:
            self._origin += behind
            self.lost += behind
