"""The period in which nothing happens but the law: judged and computed in one compiled call."""

import numpy as np

from ur5_ros.control import law_kernel
from ur5_ros.control.settings import Settings
from ur5_ros.control.state_validation import LARGEST
from ur5_ros.signals import ArmState, Reference


class OrdinaryPeriods:
    """
    The law with its checks, for periods that need nothing else; equal bits to the long way.

    Parameters
    ----------
    settings : Settings
        What the controller goes by.

    """

    def __init__(self, settings: Settings) -> None:
        arm, gains, limits = settings.arm, settings.gains, settings.arm.limits
        self.possible = (settings.mode == 'computed_torque' and not settings.gravity_excluded
                         and np.isinf(settings.torque_rate_limit))
        """Whether the settings leave every period a chance to be ordinary."""
        largest = LARGEST / 13.0  # of the six positions and six speeds that are believed
        lower, upper, speed = np.clip([limits.lower, limits.upper, limits.velocity],
                                      -largest, largest)
        bounds = np.concatenate([lower, upper, speed, limits.effort, [settings.max_state_jump]])
        self.given = (arm.constants, arm.angle_offset, gains.kp, gains.kd, bounds,
                        np.empty(law_kernel.WORK))
        """What :attr:`compute` gets between the reference and its output."""
        law_kernel.law.prepare()
        self.compute = law_kernel.law.single
        """:func:`ur5_ros.control.law_kernel.law`, for loops that keep their own arrays."""

    def torque(self, state: ArmState, before: ArmState, reference: Reference) -> np.ndarray | None:
        """
        Return the torque with its parts, or None where a check or a limit has something to say.

        Parameters
        ----------
        state, before : ArmState
            Measured state and the one believed before it.
        reference : Reference
            What to follow.

        Returns
        -------
        numpy.ndarray, shape (5, 6), or None
            Rows as :class:`ur5_ros.signals.Torque` names them [N m].

        """
        torque = np.empty((5, 6))
        try:
            special = self.compute(state.q, state.qd, before.q, *reference, *self.given, torque)
        except TypeError:  # strided or other arrays than the nodes'
            return None
        return None if special else torque
