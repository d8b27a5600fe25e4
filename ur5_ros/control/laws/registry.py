"""Which law stands for which mode; a law is imported when it is used."""

from importlib import import_module

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.computed_torque import MODES, TorqueLaw
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.checked import CheckedLaw
from ur5_ros.control.laws.law import Law
from ur5_ros.model.parameters import ArmParameters

#: Mode -> module and class of its law; the choices of the parameter ``mode``.
LAWS = {
    **dict.fromkeys(MODES, 'compiled.CompiledLaw'),
    'pid': 'pid.PID',
    'computed_torque_integral': 'computed_torque_integral.ComputedTorqueIntegral',
    'slotine_li': 'slotine_li.SlotineLi',
    'adaptive': 'adaptive.Adaptive',
    'sliding_mode': 'sliding_mode.SlidingMode',
    'cartesian_impedance': 'cartesian_impedance.CartesianImpedance',
}


def law_class(parameters: ControlParameters) -> type[Law]:
    """Return the class of the law that the parameters name."""
    place = 'user_law.UserLaw' if parameters.law_file else LAWS[parameters.mode]
    module, name = place.split('.')
    return getattr(import_module(f'ur5_ros.control.laws.{module}'), name)


def is_compiled(parameters: ControlParameters) -> bool:
    """Return whether the kernel alone gives the torque."""
    other = parameters.law_file or parameters.disturbance_observer
    return parameters.mode in MODES and not other


def make_law(parameters: ControlParameters, arm: ArmParameters,
             gains: Gains) -> TorqueLaw | CheckedLaw:
    """Return the law that the parameters describe, with the checks of state and torque."""
    excluded = parameters.effort_convention == 'gravity_excluded'
    if is_compiled(parameters):
        return TorqueLaw(parameters.mode, arm, gains, excluded, parameters.max_state_jump)
    law = law_class(parameters)(arm, gains, parameters)
    if parameters.disturbance_observer:
        from ur5_ros.control.laws.disturbance_observer import DisturbanceObserver
        law = DisturbanceObserver(law)
    return CheckedLaw(law, arm, excluded, parameters.max_state_jump)
