"""Where a node listens, and when its next report is due."""

import os
import time

from ur5_ros.nodes.ros.environment import PROFILES

#: How often a node that waits reports it, with where it listens [s].
WAITING_PERIOD = 60.0


def network() -> str:
    """Return in which domain and with which network profile this process listens."""
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    profile = next((os.environ[name] for name in PROFILES if os.environ.get(name)), 'none')
    return f'ROS_DOMAIN_ID {domain}, network profile {profile}'


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
