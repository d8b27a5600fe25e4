"""A body fixed to the tool that the arm record does not declare, and how it is exchanged."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters, Payload, with_payload

#: A transition takes at most so many stages: each one loads the bodies anew.
MOST_STAGES = 100


class ToolLoad(NamedTuple):
    """The body, in ``tool0``."""

    mass: float = 0.0
    """[kg]."""
    com: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Centre of mass [m]."""
    inertia: tuple[float, ...] = (0.0,) * 6
    """Tensor about it: xx, yy, zz, xy, xz, yz [kg m^2]."""


def tool_load(parameters: SimParameters) -> ToolLoad:
    """Return the body that parameters ``payload.*`` describe."""
    return ToolLoad(parameters.payload_mass, tuple(parameters.payload_com),
                    tuple(parameters.payload_inertia))


def loaded_arm(arm: ArmParameters, mass: float, com: Sequence[float],
               inertia: Sequence[float] = (0.0,) * 6) -> ArmParameters:
    """
    Return the arm whose last link carries its declared payload and a further body.

    ``arm``: the arm; its own payload stays; ``mass``: further mass [kg]; ``com``: where, in
    ``tool0`` [m]; ``inertia``: its tensor about there: xx, yy, zz, xy, xz, yz [kg m^2].
    """
    if mass == 0.0 and not any(inertia):
        return arm
    masses, coms, tensors = (np.array(part) for part in arm.bodies)
    declared = replace(arm, mass=masses, com=coms, inertia=tensors, payload=Payload())
    try:
        return with_payload(declared, mass, np.array(com), _tensor(inertia))
    except ValueError as error:
        raise InputError(f'payload.mass, payload.com, payload.inertia: {error}') from None


class PayloadTransition:
    """
    From one body to another in equal stages of their inertial parameters.

    Mass, first and second moment about the origin of ``tool0`` are blended, so that every stage is
    a physical body.

    """

    def __init__(self, start: ToolLoad, end: ToolLoad, first: int, periods: int):
        self._start, self.end = start, end
        self._first, self._periods = first, periods
        self._stages = min(periods, MOST_STAGES)

    def at(self, k: int) -> ToolLoad:
        """Return the body of a control period."""
        stage = min((k - self._first + 1) * self._stages // self._periods, self._stages)
        if stage == self._stages:
            return self.end
        return blend(self._start, self.end, stage / self._stages)


class HeldPayload:
    """The body at the tool, exchanged at once or in the stages of a transition."""

    def __init__(self, parameters: SimParameters):
        self.load = tool_load(parameters)
        self._transition: PayloadTransition | None = None

    def change(self, parameters: SimParameters, k: int) -> None:
        """Exchange the body for the one that parameters describe, from period ``k`` on."""
        target = tool_load(parameters)
        periods = round(parameters.payload_transition_time * parameters.control_rate)
        if periods > 0:
            self._transition = PayloadTransition(self.load, target, k, periods)
        else:
            self.load, self._transition = target, None

    @property
    def changing(self) -> bool:
        """Whether a transition is under way."""
        return self._transition is not None

    def take_stage(self, k: int) -> bool:
        """Take the stage of period ``k``; return whether the body is another."""
        if self._transition is None:
            return False
        before, self.load = self.load, self._transition.at(k)
        if self.load == self._transition.end:
            self._transition = None
        return self.load != before


def blend(start: ToolLoad, end: ToolLoad, share: float) -> ToolLoad:
    """Return the body whose inertial parameters lie between those of two."""
    masses, weight = np.array([start.mass, end.mass]), np.array([1.0 - share, share])
    coms = np.array([start.com, end.com])
    mass = float(weight @ masses)
    if mass == 0.0:
        return ToolLoad(0.0, end.com)
    com = (weight * masses) @ coms / mass
    spread = coms - com
    parts = [_tensor(load.inertia) + m * (r @ r * np.eye(3) - np.outer(r, r))
             for load, m, r in zip((start, end), masses, spread, strict=True)]
    tensor = weight[0] * parts[0] + weight[1] * parts[1]
    rows = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return ToolLoad(mass, tuple(com.tolist()), tuple(rows.tolist()))


def _tensor(inertia: Sequence[float]) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
