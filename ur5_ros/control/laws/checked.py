"""A law with the checks of state and torque that the compiled ones have inside."""

import numpy as np

from ur5_ros.control import kernel
from ur5_ros.control.laws.law import Law
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference

#: After a longer time without a state, or when time goes back, a law begins anew [s].
LONGEST_GAP = 1.0


class CheckedLaw:
    """
    A law as the controller calls it; see :class:`ur5_ros.control.computed_torque.TorqueLaw`.

    ``max_state_jump``: largest distance of a joint between two states [rad].

    """

    def __init__(self, law: Law, arm: ArmParameters, gravity_excluded: bool,
                 max_state_jump: float) -> None:
        self.law = law
        self._limits, self._gravity_excluded = arm.limits, gravity_excluded
        self._jump = max_state_jump
        self._stamp: int | None = None

    def __call__(self, state: ArmState, q_before: np.ndarray, reference: Reference,
                 torque_before: np.ndarray, largest_change: float) -> tuple[np.ndarray, int]:
        """Return the torque with its parts, and which bounds it or the state exceeds."""
        code = 0 if self._plausible(state, q_before) else kernel.STATE
        if code and state.q is not q_before:
            return np.zeros((5, 6)), code  # asked again, once it is known what to do with it
        if not (np.isfinite(state.q).all() and np.isfinite(state.qd).all()):
            return np.full((5, 6), np.nan), kernel.STATE | kernel.NOT_FINITE
        parts = np.array(self.law(state, reference, self._period(state.stamp)))
        whole = parts[kernel.TOTAL].copy()
        if not np.isfinite(whole).all():
            return parts, code | kernel.NOT_FINITE
        if self._gravity_excluded:
            parts[kernel.TOTAL] -= parts[kernel.GRAVITY]
        if not (np.abs(whole) <= self._limits.effort).all():
            code |= kernel.EFFORT
        if not (np.abs(parts[kernel.TOTAL] - torque_before) <= largest_change).all():
            code |= kernel.RATE
        return parts, code

    def _plausible(self, state: ArmState, q_before: np.ndarray) -> bool:
        limits = self._limits
        return bool((np.abs(state.q - q_before) <= self._jump).all()
                    and (limits.lower <= state.q).all() and (state.q <= limits.upper).all()
                    and (np.abs(state.qd) <= limits.velocity).all())

    def _period(self, stamp: int) -> float:
        """Return the time since the state before [s]; where that is no period, begin anew."""
        before, self._stamp = self._stamp, stamp
        period = 0.0 if before is None else (stamp - before) * 1e-9
        if not 0.0 <= period <= LONGEST_GAP:
            self.law.reset()
            return 0.0
        return period
