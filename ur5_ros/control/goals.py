"""Trajectory goals of the action: one at a time, watched until its verdict."""

import numpy as np

from ur5_ros.control.tolerances import ResultCode, Tolerances, Verdict, judge

#: Verdicts that are kept [count].
_KEPT_VERDICTS = 16


class GoalMonitor:
    """The active goal and the verdicts on those before it."""

    def __init__(self, names: list[str]):
        self._names = names
        self._number = 0
        self._tolerances: Tolerances | None = None
        self._end = 0
        self._verdicts: dict[int, Verdict] = {}

    @property
    def active(self) -> bool:
        """Whether a goal is active."""
        return self._tolerances is not None

    def start(self, tolerances: Tolerances, end: int) -> int:
        """
        Watch a new goal.

        ``end``: stamp at which its trajectory ends [ns].
        """
        self._number += 1
        self._tolerances, self._end = tolerances, end
        return self._number

    def update(self, error: np.ndarray, stamp: int) -> Verdict | None:
        """
        Judge the goal at a state.

        ``error`` (3, 6): errors of position, velocity, acceleration (NaN = not measured);
        ``stamp``: of the state [ns].
        """
        if self._tolerances is None:
            return None
        verdict = judge(self._tolerances, error, (stamp - self._end) / 1e9, self._names)
        if verdict is not None:
            self.end(verdict)
        return verdict

    def end(self, verdict: Verdict) -> None:
        """End the active goal, if any, with a verdict."""
        if self._tolerances is None:
            return
        self._tolerances = None
        self._verdicts[self._number] = verdict
        self._verdicts.pop(self._number - _KEPT_VERDICTS, None)

    def preempt(self, by: str) -> None:
        """End the active goal, if any, because another request replaces it."""
        self.end(Verdict(ResultCode.INVALID_GOAL, f'preempted by {by}'))

    def verdict(self, number: int) -> Verdict | None:
        """Return how a goal ended; None while it is active."""
        return self._verdicts.get(number)
