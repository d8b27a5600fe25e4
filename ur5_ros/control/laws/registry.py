"""Which law stands for which mode."""

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.computed_torque import MODES, TorqueLaw
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.adaptive import Adaptive
from ur5_ros.control.laws.cartesian_impedance import CartesianImpedance
from ur5_ros.control.laws.checked import CheckedLaw
from ur5_ros.control.laws.compiled import CompiledLaw
from ur5_ros.control.laws.computed_torque_integral import ComputedTorqueIntegral
from ur5_ros.control.laws.disturbance_observer import DisturbanceObserver
from ur5_ros.control.laws.law import Law
from ur5_ros.control.laws.pid import PID
from ur5_ros.control.laws.sliding_mode import SlidingMode
from ur5_ros.control.laws.slotine_li import SlotineLi
from ur5_ros.control.laws.user_law import UserLaw
from ur5_ros.model.parameters import ArmParameters

#: Mode -> law; the choices of the parameter ``mode``.
LAWS: dict[str, type[Law]] = {
    **dict.fromkeys(MODES, CompiledLaw),
    'pid': PID,
    'computed_torque_integral': ComputedTorqueIntegral,
    'slotine_li': SlotineLi,
    'adaptive': Adaptive,
    'sliding_mode': SlidingMode,
    'cartesian_impedance': CartesianImpedance,
}


def law_class(parameters: ControlParameters) -> type[Law]:
    """Return the class of the law that the parameters name."""
    return UserLaw if parameters.law_file else LAWS[parameters.mode]


def is_compiled(parameters: ControlParameters) -> bool:
    """Return whether the kernel alone gives the torque."""
    return law_class(parameters) is CompiledLaw and not parameters.disturbance_observer


def make_law(parameters: ControlParameters, arm: ArmParameters,
             gains: Gains) -> TorqueLaw | CheckedLaw:
    """Return the law that the parameters describe, with the checks of state and torque."""
    excluded = parameters.effort_convention == 'gravity_excluded'
    if is_compiled(parameters):
        return TorqueLaw(parameters.mode, arm, gains, excluded, parameters.max_state_jump)
    law = law_class(parameters)(arm, gains, parameters)
    if parameters.disturbance_observer:
        law = DisturbanceObserver(law)
    return CheckedLaw(law, arm, excluded, parameters.max_state_jump)
