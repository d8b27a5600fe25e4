"""Throttled log lines, counted refusals, and when the next report is due."""

import os
import time
from collections.abc import Callable
from typing import Any

from ur5_ros.nodes.ros.environment import PROFILES

#: Wall time between two log lines of the same kind [s].
THROTTLE = 1.0


#: How often a node that waits reports it, with where it listens [s].
WAITING_PERIOD = 60.0


def network() -> str:
    """Return in which domain and with which network profile this process listens."""
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    profile = next((os.environ[name] for name in PROFILES if os.environ.get(name)), 'none')
    return f'ROS_DOMAIN_ID {domain}, network profile {profile}'


class Throttle:
    """Lets a line of each kind through once in a while, counting the others."""

    def __init__(self, seconds: float = THROTTLE, now: Callable[[], float] = time.monotonic):
        self._seconds = seconds
        self._now = now
        self._last: dict[str, float] = {}
        self._skipped: dict[str, int] = {}

    def __call__(self, kind: str) -> bool:
        """Return whether a line of this kind may go out now."""
        now = self._now()
        if now - self._last.get(kind, -1e9) < self._seconds:
            self._skipped[kind] = self._skipped.get(kind, 0) + 1
            return False
        self._last[kind] = now
        return True

    def skipped(self, kind: str) -> int:
        """Return how many lines of this kind were held back since the last call."""
        return self._skipped.pop(kind, 0)


class Refusals:
    """
    Counts what was refused, by topic and kind, and reports them in words now and then.

    ``report``: ``report(topic, reason, count)`` is called with every line.

    """

    def __init__(
        self, warn: Callable[[str], Any],
        report: Callable[[str, str, int], None] = lambda topic, reason, count: None,
    ) -> None:
        self.counts: dict[str, int] = {}
        """``'<topic>: <kind>'`` to how often."""
        self.last = ''
        """The last refusal in words."""
        self._warn = warn
        self._report = report
        self._throttle = Throttle()

    @property
    def total(self) -> int:
        """How much was refused in all."""
        return sum(self.counts.values())

    def add(self, topic: str, kind: str, reason: str) -> None:
        """Count a refusal."""
        key = f'{topic}: {kind}'
        self.last = f'{topic}: {reason}'
        count = self.counts[key] = self.counts.get(key, 0) + 1
        if self._throttle(key):
            self._warn(f'refused {topic}: {reason}' + (f' ({count} so far)' if count > 1 else ''))
            self._report(topic, reason, count)


class EverySecond:
    """
    Knows when the next report is due, on the steady clock.

    ``period``: wall time [s].

    """

    def __init__(self, period: float = 1.0) -> None:
        self._period = period
        self._next = time.monotonic()

    def due(self) -> bool:
        """Return whether it is time, and plan the next."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = now + self._period
        return True
