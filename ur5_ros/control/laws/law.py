"""What a law is: state and reference in, joint torque with its parts out."""

from abc import ABC, abstractmethod

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.stability import check_sampled
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

_NO_WRENCH = np.zeros(6)
_NO_WRENCH.flags.writeable = False


class Law(ABC):
    """
    A control law with its memory.

    Parameters
    ----------
    arm : ArmParameters
        The model that the law uses.
    gains : Gains
        KP, KD.
    parameters : ControlParameters
        Every parameter of the controller, for the law's own ones.

    """

    #: Whether the gains are weighed by M: [1/s^2] and [1/s], not [N m/rad] and [N m s/rad].
    weighed = True
    #: Desired force [N] and torque [N m] of the tool on its surroundings, in base.
    target_wrench = _NO_WRENCH

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        self.arm, self.gains, self.parameters = arm, gains, parameters

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse (InputError) what is unstable when sampled at ``control_rate`` [Hz]."""
        check_sampled(parameters.mode, gains, cls.weighed, arm, control_rate)

    def reset(self) -> None:  # noqa: B027  a law without memory has nothing to forget
        """Forget what was before: the next state is the first."""

    @abstractmethod
    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """
        Return the torque, gravity included.

        Parameters
        ----------
        state : ArmState
            Measured state.
        reference : Reference
            What to follow.
        dt : float
            Time since the state before [s]; 0 for the first.

        """


def model_terms(state: ArmState, arm: ArmParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return M, C and g of a state."""
    return dynamics_terms(state.q + arm.angle_offset, state.qd, arm)


def torque_of(inertial: np.ndarray, feedback: np.ndarray, coriolis: np.ndarray,
              gravity: np.ndarray) -> Torque:
    """Return the torque that is the sum of its parts."""
    return Torque(inertial + feedback + coriolis + gravity, inertial, feedback, coriolis, gravity)
