"""
Simulated torque control of Universal Robots arms in ROS 2, with evidence.

The names of ``__all__`` are the public API; docs/reference/python.md describes each of them. Every
other name of the package is internal: it may change in any version.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ur5_ros.analysis.data.load import load_run as load_run
    from ur5_ros.analysis.identification.identify import identify as identify
    from ur5_ros.analysis.validate import validate as validate
    from ur5_ros.bag.reader import open_bag as open_bag
    from ur5_ros.config.arms import load_arm as load_arm
    from ur5_ros.control.computed_torque import computed_torque as computed_torque
    from ur5_ros.control.controller import Controller as Controller
    from ur5_ros.control.gains import Gains as Gains
    from ur5_ros.errors import InputError as InputError
    from ur5_ros.loop.closed_loop import run_closed_loop as run_closed_loop
    from ur5_ros.loop.run_config import run_config as run_config
    from ur5_ros.model.dynamics import coriolis_matrix as coriolis_matrix
    from ur5_ros.model.dynamics import dynamics_terms as dynamics_terms
    from ur5_ros.model.dynamics import forward_dynamics as forward_dynamics
    from ur5_ros.model.dynamics import gravity_torque as gravity_torque
    from ur5_ros.model.dynamics import inertia_matrix as inertia_matrix
    from ur5_ros.model.dynamics import inverse_dynamics as inverse_dynamics
    from ur5_ros.model.energy import kinetic_energy as kinetic_energy
    from ur5_ros.model.energy import potential_energy as potential_energy
    from ur5_ros.model.inverse_kinematics import inverse_kinematics as inverse_kinematics
    from ur5_ros.model.inverse_kinematics import (
        inverse_kinematics_batch as inverse_kinematics_batch,
    )
    from ur5_ros.model.inverse_kinematics import nearest_solution as nearest_solution
    from ur5_ros.model.kinematics import forward_kinematics as forward_kinematics
    from ur5_ros.model.kinematics import jacobian as jacobian
    from ur5_ros.model.kinematics import jacobian_rate as jacobian_rate
    from ur5_ros.model.kinematics import link_transforms as link_transforms
    from ur5_ros.model.kinematics import singularity_factors as singularity_factors
    from ur5_ros.model.regressor import dynamics_regressor as dynamics_regressor
    from ur5_ros.signals import JOINT_NAMES as JOINT_NAMES
    from ur5_ros.signals import ArmState as ArmState
    from ur5_ros.signals import Reference as Reference
    from ur5_ros.signals import Torque as Torque
    from ur5_ros.sim.plant import Plant as Plant

__version__ = '0.2.0'

#: Module -> the public names in it. A module is imported when one of its names is first used, so
#: that a process loads only what it needs.
_NAMES = {
    'config.arms': 'load_arm',
    'model.kinematics': 'forward_kinematics link_transforms jacobian jacobian_rate '
                        'singularity_factors',
    'model.inverse_kinematics': 'inverse_kinematics inverse_kinematics_batch nearest_solution',
    'model.dynamics': 'inertia_matrix coriolis_matrix gravity_torque dynamics_terms '
                      'inverse_dynamics forward_dynamics',
    'model.energy': 'kinetic_energy potential_energy',
    'model.regressor': 'dynamics_regressor',
    'signals': 'JOINT_NAMES ArmState Reference Torque',
    'control.gains': 'Gains',
    'control.computed_torque': 'computed_torque',
    'control.controller': 'Controller',
    'sim.plant': 'Plant',
    'loop.run_config': 'run_config',
    'loop.closed_loop': 'run_closed_loop',
    'bag.reader': 'open_bag',
    'analysis.data.load': 'load_run',
    'analysis.validate': 'validate',
    'analysis.identification.identify': 'identify',
    'errors': 'InputError',
}
_MODULE = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = tuple(_MODULE)


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    value = getattr(import_module(f'{__name__}.{_MODULE[name]}'), name)
    globals()[name] = value  # the next access comes without this function
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
