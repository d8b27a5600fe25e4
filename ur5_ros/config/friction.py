"""Friction as parameters of the simulator, and that of an arm file in their place."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.parameters import SIM_PARAMETERS
from ur5_ros.errors import InputError
from ur5_ros.model.friction import JointFriction

_DEFAULTS = {parameter.name: parameter.default for parameter in SIM_PARAMETERS}
_PARTS = {f'friction.{part.name}': part.name for part in fields(JointFriction)}


def joint_friction(parameters: Mapping[str, Any]) -> JointFriction:
    """Return the friction that parameters ``friction.*`` describe, absent ones by default."""
    try:
        return JointFriction(**{part: np.array(parameters.get(name, _DEFAULTS[name]), dtype=float)
                                for name, part in _PARTS.items()})
    except ValueError as error:
        raise InputError(str(error)) from None


def with_arm_friction(parameters: SimParameters, friction: JointFriction) -> SimParameters:
    """
    Return parameters of the simulator with an arm's friction where they ask for it.

    Where ``friction.from_arm`` is true, the arm's numbers stand in place of those parameters
    ``friction.*`` that have their default; doing it again changes nothing.

    """
    if not parameters.friction_from_arm:
        return parameters
    given = parameters.by_name()
    return parameters.replaced({name: getattr(friction, part).tolist()
                                for name, part in _PARTS.items()
                                if given[name] == _DEFAULTS[name]})
