"""The parameters of the plant, some of which change while it runs."""

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
    """Parameters, always valid together."""

    def __init__(self, parameters: SimParameters, arm: ArmParameters):
        self.parameters = with_arm_friction(parameters, arm.friction)
        self._arm = arm
        self._check(self.parameters)

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

    def effects(self, wrench: np.ndarray) -> Effects:
        """Return what acts on the joints beside bodies, gravity and motors."""
        return Effects(
            self._arm.armature, joint_friction(self.parameters.by_name()), wrench,
            self._arm.limits.lower, self._arm.limits.upper)
