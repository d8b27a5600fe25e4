"""What can change while the plant runs: live parameters and the wrench at the tool."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5_ros.config.friction import joint_friction, with_arm_friction
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.parameters import SIM_PARAMETERS, check
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.integrator import Effects
from ur5_ros.sim.payload import loaded_arm, tool_load

_LIVE = {parameter.name: parameter for parameter in SIM_PARAMETERS if parameter.live}


class PlantParameters:
    """Parameters and wrench, always valid."""

    def __init__(self, parameters: SimParameters, arm: ArmParameters):
        self.parameters = with_arm_friction(parameters, arm.friction)
        self._arm = arm
        self._check(self.parameters)
        self.wrench = np.zeros(6)
        """Force [N] and torque [N m] at the origin of ``tool0``, in ``base``."""

    def change(self, name: str, value: Any) -> Any:
        """Change a parameter; return its value in the right type."""
        if name not in _LIVE:
            known = any(name == each.name for each in SIM_PARAMETERS)
            what = 'cannot change during a run' if known else 'is no parameter'
            raise InputError(f'{name} {what}; these can: {", ".join(_LIVE)}')
        value = check(_LIVE[name], value)
        changed = self.parameters.replaced({name: value})
        self._check(changed)
        self.parameters = changed
        return value

    def _check(self, parameters: SimParameters) -> None:
        """Refuse values that are right one by one and wrong together."""
        joint_friction(parameters.by_name())
        loaded_arm(self._arm, *tool_load(parameters))

    def set_wrench(self, force: Sequence[float], torque: Sequence[float], frame: str) -> None:
        """Set the wrench."""
        wrench = np.concatenate([np.asarray(force, dtype=float), np.asarray(torque, dtype=float)])
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            raise InputError(f'wrench {wrench.tolist()}; give three finite numbers each [N], [N '
                             'm]')
        if frame not in ('base', 'base_link'):
            raise InputError(f'wrench in frame {frame!r}; give base or base_link')
        if frame == 'base_link':  # base is base_link turned by Rz(pi)
            wrench = wrench * [-1.0, -1.0, 1.0, -1.0, -1.0, 1.0]
        self.wrench = wrench + 0.0  # no negative zeros

    def effects(self, arm: ArmParameters) -> Effects:
        """Return what acts on the joints of this arm beside bodies, gravity and motors."""
        return Effects(
            arm.armature, joint_friction(self.parameters.by_name()), self.wrench, arm.limits.lower,
            arm.limits.upper)
