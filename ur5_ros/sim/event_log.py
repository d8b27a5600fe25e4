"""Events of the plant in order, counters, the fallback and the protective stop that act."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, ArmState
from ur5_ros.sim.events import Event, event
from ur5_ros.sim.limits import LimitMonitor


class EventLog:
    """Logs every change once."""

    def __init__(self, arm: ArmParameters):
        self._fastest = arm.limits.velocity
        self.limits = LimitMonitor()
        """The joints at a limit in the last period."""
        self._events: list[Event] = []
        self.fallback = ''
        """The fallback that acts, empty while commands do."""
        self.stopped = False
        """Whether a protective stop is latched."""
        self.counts = {'fallback_periods': 0, 'protective_stops': 0, 'resets': 0}

    @property
    def counters(self) -> dict[str, int]:
        """Return how often what happened."""
        return self.counts | {f'limit_{kind}_periods': count
                              for kind, count in self.limits.periods.items()}

    def add(self, stamp: int, kind: str, message: str, /, **values: Any) -> None:
        """Note an event that acts from a state [ns]."""
        self._events.append(event(stamp, kind, message, **values))

    def drain(self) -> list[Event]:
        """Return what happened since the last call, in the order in which it did."""
        events, self._events = self._events, []
        return events

    def fall_back(self, stamp: int, mode: str) -> None:
        """Note which fallback acts from a state on; empty = a command does."""
        if mode == self.fallback:
            return
        message = f'{mode} acts' if mode else f'{self.fallback} ends: a command acts'
        self.add(stamp, 'fallback', message, mode=mode or self.fallback, active=bool(mode))
        self.fallback = mode

    def stop(self, stamp: int, joints: Sequence[str], why: str) -> None:
        """Latch a protective stop."""
        self.stopped = True
        self.counts['protective_stops'] += 1
        self.add(stamp, 'protective_stop',
                  f'protective stop: {why}; the brake acts until a reset', joints=list(joints))

    def check_limits(self, before: int, after: ArmState, clamped: np.ndarray, held: np.ndarray,
                       overspeed_stop: bool) -> None:
        """
        Log the joints that began or ceased to touch a limit in a period.

        ``before``: stamp of the state at its start [ns]; ``clamped``, ``held`` (6,): joints whose
        torque was clamped, joints that a stop held.
        """
        fast = np.abs(after.qd) > self._fastest
        for kind, mask, stamp in (('effort', clamped, before), ('position', held, before),
                                  ('velocity', fast, after.stamp)):
            change = self.limits.update(kind, mask, stamp)
            if change is not None:
                self._events.append(change)
        if fast.any() and overspeed_stop and not self.stopped:
            self.stop(after.stamp, [JOINT_NAMES[i] for i in np.flatnonzero(fast)], 'over-speed')
