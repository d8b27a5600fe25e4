"""One run as the parameters of both sides: what the demo, a sweep and the loop start from."""

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.config.experiments import Experiment, load_experiment
from ur5_ros.config.friction import with_arm_friction
from ur5_ros.config.node_parameters import ControlParameters, SimParameters
from ur5_ros.config.worlds import world_from
from ur5_ros.control.experiment import initial_positions
from ur5_ros.control.gains import gains_from
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.limits import check_rates

#: Physics steps a second that a run does not go below unless asked [Hz].
PHYSICS_RATE = 1000


class RunConfig(NamedTuple):
    """One run before it runs."""

    sim: SimParameters
    """Every parameter of the simulator."""
    control: ControlParameters
    """Every parameter of the controller."""
    duration: float
    """Simulated time [s]."""

    @property
    def periods(self) -> int:
        """How many states there are: the simulator ends with the one at ``stop_after``."""
        return max(1, round(self.sim.stop_after * self.sim.control_rate))


def run_config(
    experiment: str = 'kebria_fig11', arm: str = 'ur5', control_arm: str | None = None,
    control_rate: int = 1000, physics_rate: int | None = None,
    initial_error: float | list[float] | None = None, duration: float | None = None,
    sim: Mapping[str, Any] | None = None, control: Mapping[str, Any] | None = None,
) -> RunConfig:
    """
    Return the parameters of both sides for an experiment.

    Parameters
    ----------
    experiment : str
        Name or file of the experiment.
    arm, control_arm : str
        Names or files of the simulator's arm and of the law's; the same one by default.
    control_rate : int
        Control periods a second [Hz].
    physics_rate : int, optional
        Physics steps a second [Hz]; by default the multiple of ``control_rate`` that reaches
        1000 Hz.
    initial_error : float or six of them, optional
        q(0) - q*(0) [rad]; the experiment's own by default.
    duration : float, optional
        Simulated time [s]; the experiment's by default.
    sim, control : mapping, optional
        Further parameters of either side.

    Raises
    ------
    InputError
        If a name is unknown, a value out of range, or the rates do not divide.

    Examples
    --------
    >>> from ur5_ros import run_config
    >>> config = run_config('joint_step', arm='ur5', control_rate=500, duration=0.5)
    >>> config.duration, config.sim.control_rate, config.control.experiment
    (0.5, 500, 'joint_step')

    """
    control_arm = arm if control_arm is None else control_arm
    spec = _experiment(experiment)
    if not arm_named(arm).has_tensors:
        raise InputError(f'arm {arm} has point masses, which cannot be simulated; '
                         'give one with tensors, such as ur5_real')
    duration = float(spec.duration if duration is None else duration)
    if physics_rate is None and control_rate > 0:
        physics_rate = control_rate * -(-PHYSICS_RATE // control_rate)
    start = _start(experiment, control_arm)
    if initial_error is not None:
        start = start - np.array(spec.initial_error) + np.array(initial_error, dtype=float)
    sim_parameters = SimParameters.of({
        'arm': arm, 'control_rate': control_rate, 'physics_rate': physics_rate,
        'initial_positions': start.tolist(), 'stop_after': duration, 'world': spec.world,
        **spec.sim, **(sim or {})})
    sim_parameters = with_arm_friction(sim_parameters, arm_named(arm).friction)
    control_parameters = ControlParameters.of({
        'arm': control_arm, 'experiment': experiment, 'autostart': True,
        'effort_convention': sim_parameters.effort_convention, **spec.control,
        **(control or {})})
    check_rates(sim_parameters.control_rate, sim_parameters.physics_rate)
    world_from(sim_parameters)  # refused before anything runs
    if control_parameters.mode == 'computed_torque':
        gains_from(control_parameters.kp, control_parameters.kd)
    return RunConfig(sim_parameters, control_parameters, duration)


@cache
def arm_named(name: str) -> ArmParameters:
    """Return an arm, read once a process; see :func:`ur5_ros.config.load_arm`."""
    return load_arm(name)


@cache
def _experiment(name: str) -> Experiment:
    return load_experiment(name)


@cache
def _start(experiment: str, arm: str) -> np.ndarray:
    return np.asarray(initial_positions(_experiment(experiment), arm_named(arm)), dtype=float)
