"""What a law has to survive: one thing that it does not know, drawn by a seed."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters

#: Arm of the bench: a UR5 with the rotors of its motors.
ARM = 'ur5_real'
#: Joint errors at the start are drawn within this [rad].
START_ERROR = 0.02
#: A law whose largest joint error stays below the first has survived; below the second it is
#: still accurate [rad].
SURVIVES, ACCURATE = 0.2, 0.02


@dataclass(frozen=True)
class Conditions:
    """What differs from the ordinary run."""

    experiment: str = 'multi_sine'
    control_rate: int = 1000
    survives: float = SURVIVES
    """A law whose largest joint error stays below this has survived [rad]."""
    sim: dict[str, Any] = field(default_factory=dict)
    sim_arm: Callable[[ArmParameters], ArmParameters] = lambda arm: arm
    control_arm: Callable[[ArmParameters], ArmParameters] = lambda arm: arm


def nothing(random: np.random.Generator) -> Conditions:
    """Only the error at the start."""
    return Conditions()


def payload(random: np.random.Generator) -> Conditions:
    """1 to 3 kg at the tool."""
    return Conditions(sim={'payload.mass': random.uniform(1.0, 3.0),
                           'payload.com': random.uniform(-0.05, 0.05, 3).tolist()})


def friction(random: np.random.Generator) -> Conditions:
    """Coulomb and viscous friction of the size of the robot's."""
    size = np.array([10.0, 10.0, 8.0, 2.0, 2.0, 2.0]) * random.uniform(0.5, 1.0, 6)
    return Conditions(sim={'friction.coulomb': (0.5 * size).tolist(),
                           'friction.viscous': size.tolist()})


def wrong_masses(random: np.random.Generator) -> Conditions:
    """Every mass of the controller's arm is wrong by up to 20 %, its tensor with it."""
    factor = random.uniform(0.8, 1.2, 6)

    def scaled(arm: ArmParameters) -> ArmParameters:
        return replace(arm, mass=arm.mass * factor, inertia=arm.inertia * factor[:, None, None])
    return Conditions(control_arm=scaled)


def noise(random: np.random.Generator) -> Conditions:
    """Noise of encoders and velocities."""
    return Conditions(sim={'noise.position': 5e-5, 'noise.velocity': 5e-3,
                           'seed': int(random.integers(1 << 31))})


def delay(random: np.random.Generator) -> Conditions:
    """Commands act 2 to 5 ms late."""
    return Conditions(sim={'delay.command_periods': int(random.integers(2, 6))})


def rate(random: np.random.Generator) -> Conditions:
    """250 control periods a second in place of 1000."""
    return Conditions(control_rate=250)


def torque_limits(random: np.random.Generator) -> Conditions:
    """Joint torques are limited to 35 to 45 % of the robot's."""
    share = random.uniform(0.35, 0.45)

    def limited(arm: ArmParameters) -> ArmParameters:
        return replace(arm, limits=replace(arm.limits, effort=share * arm.limits.effort))
    return Conditions(sim_arm=limited, control_arm=limited)


def contact(random: np.random.Generator) -> Conditions:
    """The tool is led against a wall, to a goal 40 mm behind it."""
    return Conditions(experiment='tap_wall', survives=0.4)


PERTURBATIONS: dict[str, Callable[[np.random.Generator], Conditions]] = {
    each.__name__: each for each in (
        payload, friction, wrong_masses, noise, delay, rate, torque_limits, contact)}

#: Those of ``--quick``.
QUICK = ('payload', 'delay')


def conditions_of(name: str, seed: int) -> tuple[Conditions, np.ndarray]:
    """
    Return the conditions of a run and its joint error at the start.

    ``name``: A key of :data:`PERTURBATIONS`, or ``nothing``.
    """
    known = {'nothing': nothing, **PERTURBATIONS}
    if name not in known:
        raise InputError(f'unknown perturbation {name!r}; give one of: {", ".join(known)}')
    random = np.random.default_rng([seed, *name.encode()])
    error = random.uniform(-START_ERROR, START_ERROR, 6)
    return known[name](random), error
