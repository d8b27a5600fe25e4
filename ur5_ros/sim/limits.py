"""Limits of the joints: an event when a joint begins or ceases to touch one."""

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.events import Event, event

_MESSAGES = {
    'effort': 'commanded torque clamped to the limit of {}',
    'velocity': 'faster than the limit: {}',
    'position': 'held by the stop: {}',
}


class LimitMonitor:
    """Counts the periods at a limit and returns every change as an event."""

    def __init__(self):
        self.periods = dict.fromkeys(_MESSAGES, 0)
        self.quiet = True  # no joint is at a limit
        self._touching: dict[str, tuple[str, ...]] = dict.fromkeys(_MESSAGES, ())

    def update(self, kind: str, mask: np.ndarray, stamp: int) -> Event | None:
        """
        Take note of the joints at a limit in one period.

        ``kind``: ``effort``, ``velocity`` or ``position``; ``mask`` (6,): the joints at the limit;
        ``stamp``: stamp of the state from which that holds [ns].
        """
        joints = tuple(name for name, at_limit in zip(JOINT_NAMES, mask, strict=True) if at_limit)
        self.periods[kind] += bool(joints)
        if joints == self._touching[kind]:
            return None
        self._touching[kind] = joints
        self.quiet = not any(self._touching.values())
        message = (_MESSAGES[kind].format(', '.join(joints)) if joints
                   else f'all joints are within their {kind} limits again')
        return event(stamp, 'limit', message, kind=kind, joints=list(joints), active=bool(joints))


def state_bounds(arm: ArmParameters) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the largest q [rad] and qd [rad/s] within the limits, (12,) each."""
    limits = arm.limits
    return (np.concatenate([limits.lower, -limits.velocity]),
            np.concatenate([limits.upper, limits.velocity]))


def check_initial_state(arm: ArmParameters, positions: list[float]) -> None:
    """Refuse to start beyond a stop."""
    for name, q, low, high in zip(JOINT_NAMES, positions, arm.limits.lower, arm.limits.upper,
                                  strict=True):
        if not low <= q <= high:
            raise InputError(f'initial_positions: {name} {q:g} rad is beyond a stop of '
                             f'{arm.name}; give {low:g} to {high:g}')


def check_rates(control_rate: int, physics_rate: int) -> None:
    """Refuse a control period that is not a whole number of physics steps."""
    if physics_rate % control_rate == 0:
        return
    fitting = [rate for rate in range(1, physics_rate + 1) if physics_rate % rate == 0]
    near = [max((rate for rate in fitting if rate < control_rate), default=None),
            min((rate for rate in fitting if rate > control_rate), default=None)]
    raise InputError(f'control_rate {control_rate} Hz does not divide physics_rate {physics_rate} '
                     f'Hz; use {" or ".join(str(rate) for rate in near if rate)}')
