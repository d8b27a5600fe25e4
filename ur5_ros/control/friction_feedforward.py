"""Friction feed-forward: the torque that friction takes at the desired speed, added to a law's."""

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.kernel import CORIOLIS, EFFORT, GRAVITY, NOT_FINITE, RATE, STATE, TOTAL
from ur5_ros.errors import InputError
from ur5_ros.model.friction import friction_torque
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference


def friction_feedforward(parameters: ControlParameters,
                         arm: ArmParameters) -> 'FrictionFeedforward | None':
    """Return the feed-forward that the parameters ask for; None where they do not."""
    if not parameters.friction_feedforward:
        return None
    return FrictionFeedforward(arm, parameters.effort_convention == 'gravity_excluded')


class FrictionFeedforward:
    """
    What is added to the torque of a law.

    It goes by the desired speed, not by the measured one, whose sign at rest is noise; the load is
    that of the law's gravity and Coriolis torque.

    """

    def __init__(self, arm: ArmParameters, gravity_excluded: bool) -> None:
        if arm.friction.none:
            raise InputError(f'friction_feedforward is true, but arm {arm.name} has no friction; '
                             'give one whose file has a section friction, such as ur5e_real')
        self._arm, self._gravity_excluded = arm, gravity_excluded

    def __call__(self, parts: np.ndarray, code: int, reference: Reference,
                 torque_before: np.ndarray, largest_change: float) -> tuple[np.ndarray, int]:
        """
        Return the torque with friction in its total, and which bounds are then exceeded.

        ``parts`` (5, 6): the law's torque and its parts [N m]; ``torque_before`` (6,): the command
        before [N m]; ``largest_change``: largest change of a joint torque since then [N m].
        """
        if code & (STATE | NOT_FINITE):
            return parts, code
        gravity = parts[GRAVITY]
        parts[TOTAL] += friction_torque(self._arm.friction, reference.qd,
                                        gravity + parts[CORIOLIS])
        whole = parts[TOTAL] + gravity if self._gravity_excluded else parts[TOTAL]
        code = 0 if (np.abs(whole) <= self._arm.limits.effort).all() else EFFORT
        if not (np.abs(parts[TOTAL] - torque_before) <= largest_change).all():
            code |= RATE
        return parts, code
