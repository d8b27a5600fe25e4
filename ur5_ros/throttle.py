"""What recurs: let through once in a while, and counted where it is a refusal."""

import time
from collections.abc import Callable, Hashable

#: Wall time between two reports of the same kind [s].
PERIOD = 1.0


class Throttle:
    """Lets a report of each kind through once in a while, counting the others."""

    def __init__(self, seconds: float = PERIOD, now: Callable[[], float] = time.monotonic):
        self._seconds = seconds
        self._now = now
        self._last: dict[Hashable, float] = {}
        self._skipped: dict[Hashable, int] = {}

    def __call__(self, kind: Hashable) -> bool:
        """Return whether a report of this kind may go out now."""
        now = self._now()
        if now - self._last.get(kind, -1e9) < self._seconds:
            self._skipped[kind] = self._skipped.get(kind, 0) + 1
            return False
        self._last[kind] = now
        return True

    def skipped(self, kind: Hashable) -> int:
        """Return how many reports of this kind were held back since the last call."""
        return self._skipped.pop(kind, 0)


class RefusalCount:
    """
    Counts refusals by topic and kind; each kind is to be reported at most once a second.

    ``now``: steady time [s].

    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._throttle = Throttle(now=now)
        self.counts: dict[tuple[str, str], int] = {}

    def add(self, topic: str, kind: str) -> int:
        """Count one; return how many there were if they are to be reported now, otherwise 0."""
        count = self.counts[topic, kind] = self.counts.get((topic, kind), 0) + 1
        return count if self._throttle((topic, kind)) else 0
