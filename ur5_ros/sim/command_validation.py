"""Commands that make no sense: found, counted by reason, told without flooding."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ur5_ros.sim.events import Event, event

#: The same refusal is told again after this time [s].
TELL_AGAIN = 1.0


def in_joint_order(expected: Sequence[str], names: Sequence[str],
                   effort: Sequence[float]) -> tuple[np.ndarray | None, str]:
    """
    Return six torques in joint order, or None and why there are none.

    Parameters
    ----------
    expected : sequence of str
        The six joint names in joint order.
    names : sequence of str
        Those of the message, in any order.
    effort : sequence of float
        Torques in the order of ``names`` [N m].

    """
    if tuple(names) == tuple(expected) and len(effort) == len(expected):
        return np.array(effort, dtype=float), ''
    if tuple(names) != tuple(expected):
        if len(set(names)) != len(names):
            return None, 'doubled joint name'
        if not set(names) <= set(expected):
            return None, 'unknown joint name'
        if len(names) != len(expected):
            return None, 'missing joint name'
    if len(effort) != len(expected):
        return None, 'wrong number of torques'
    torque = dict(zip(names, effort, strict=True))
    return np.array([torque[name] for name in expected], dtype=float), ''


def is_finite(command: np.ndarray) -> bool:
    """Tell whether all torques are finite; absurd ones whose sum overflows are not."""
    return math.isfinite(sum(command.tolist()))


class RefusalCount:
    """
    Counts refusals by topic and reason, and tells each kind at most once a second.

    Parameters
    ----------
    clock : callable
        Steady time [s].

    """

    def __init__(self, clock: Callable[[], float]):
        self._clock = clock
        self._told: dict[tuple[str, str], float] = {}
        self.counts: dict[tuple[str, str], int] = {}

    def add(self, topic: str, reason: str, stamp: int) -> Event | None:
        """Count one; return an event if it is to be told."""
        key = (topic, reason)
        count = self.counts[key] = self.counts.get(key, 0) + 1
        now = self._clock()
        if now - self._told.get(key, -math.inf) < TELL_AGAIN:
            return None
        self._told[key] = now
        return event(stamp, 'refused', f'{topic}: command refused: {reason} ({count} so far)',
                     topic=topic, reason=reason, count=count)


class PublisherMonitor:
    """Watches who publishes commands; more than one is told by name."""

    def __init__(self) -> None:
        self._known: dict[str, list[str]] = {}

    def look(self, names: Mapping[str, Sequence[str]], stamp: int) -> tuple[bool, Event | None]:
        """
        Take note of the publishers.

        Parameters
        ----------
        names : mapping of str to sequence of str
            Names of the nodes by topic.
        stamp : int
            Of the present state [ns].

        Returns
        -------
        bool
            Whether there is more than one.
        Event or None
            What to tell, if they are others than before.

        """
        crowd = {topic: sorted(who) for topic, who in names.items() if who}
        everybody = [name for who in crowd.values() for name in who]
        changed, self._known = crowd != self._known, crowd
        if len(everybody) < 2 or not changed:
            return len(everybody) > 1, None
        return True, event(stamp, 'publishers', f'{len(everybody)} publishers command the arm: '
                           f'{", ".join(everybody)}; the first valid answer acts, the run cannot '
                           'be repeated', topics=sorted(crowd), names=everybody)
