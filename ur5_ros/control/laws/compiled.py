"""The compiled laws in the form of the others, for what comes on top of a law."""

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.computed_torque import UNWEIGHTED_MODES, TorqueLaw
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import Law
from ur5_ros.control.laws.stability import check_sampled
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque


class CompiledLaw(Law):
    """``computed_torque``, ``impedance``, ``gravity_pd`` or ``pd``: the bits of the kernel."""

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._law = TorqueLaw(parameters.mode, arm, gains)

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse gains that are unstable when sampled."""
        mode = parameters.mode
        check_sampled(mode, gains, mode not in UNWEIGHTED_MODES, arm, control_rate)

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque of the mode."""
        return Torque(*self._law(state, state.q, reference)[0])
