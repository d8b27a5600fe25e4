"""What is wrong with commands: their joints, their torques, several publishers."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ur5_ros.signals import JointNameError, joint_order
from ur5_ros.sim.events import Event, event


def in_joint_order(expected: Sequence[str], names: Sequence[str],
                   effort: Sequence[float]) -> tuple[np.ndarray | None, str]:
    """
    Return six torques in joint order, or None and why there are none.

    ``effort``: torques in the order of ``names`` [N m].
    """
    try:
        order = joint_order(names, expected)
    except JointNameError as error:
        return None, error.reason
    if len(effort) != len(expected):
        return None, 'wrong number of torques'
    return np.array(effort, dtype=float)[order], ''


def is_finite(torques: Sequence[float]) -> bool:
    """Return whether all torques are finite; huge ones whose sum overflows are not."""
    return math.isfinite(sum(torques))


class PublisherMonitor:
    """Watches the publishers of commands; more than one are reported by name."""

    def __init__(self) -> None:
        self._known: dict[str, list[str]] = {}

    def update(self, names: Mapping[str, Sequence[str]], stamp: int) -> tuple[bool, Event | None]:
        """
        Take note of the publishers.

        ``stamp``: of the present state [ns].
        """
        present = {topic: sorted(nodes) for topic, nodes in names.items() if nodes}
        everyone = [name for nodes in present.values() for name in nodes]
        changed, self._known = present != self._known, present
        if len(everyone) < 2 or not changed:
            return len(everyone) > 1, None
        return True, event(stamp, 'publishers', f'{len(everyone)} publishers command the arm: '
                           f'{", ".join(everyone)}; the first valid answer acts, the run cannot '
                           'be repeated', topics=sorted(present), names=everyone)
