"""What the law promises, and when it was active: what the checks of the law share."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.control.gains import Gains, gains_from

#: A recorded error may exceed what the sampled loop predicts by this factor.
BEYOND_THEORY = 1.25

#: Parameters whose change makes another law.
_LAW_PARAMETERS = {'kp', 'kd', 'ki', 'mode', 'torque_rate_limit', 'adaptation_rate',
                   'boundary_layer', 'disturbance_observer', 'observer_gain',
                   'friction_feedforward', 'impedance.stiffness', 'impedance.damping',
                   'impedance.inertia', 'impedance.frame'}

#: Modes whose torque is a function of state, reference and parameters alone.
_WITHOUT_MEMORY = ('computed_torque', 'pd', 'gravity_pd', 'impedance', 'cartesian_impedance')


class Law(NamedTuple):
    """The law that answers some of the states: rows ``first`` to ``end - 1``."""

    first: int
    end: int
    parameters: Mapping[str, Any]
    """Every parameter of the controller in this time."""
    gains: Gains

    @property
    def mode(self) -> str:
        """The law's name."""
        return self.parameters.get('mode', 'computed_torque')

    @property
    def without_memory(self) -> bool:
        """Whether its torque follows from state and reference alone."""
        return (self.mode in _WITHOUT_MEMORY and not self.parameters.get('law_file')
                and not self.parameters.get('disturbance_observer'))

    @property
    def promised(self) -> bool:
        """Whether it is computed torque, which promises e'' + Kd e' + Kp e = 0."""
        return self.without_memory and self.mode == 'computed_torque'


def laws_of(run: Run) -> list[Law]:
    """
    Return the laws in force, in order: one, and another wherever gains or mode were changed.

    A change acts on the answers to the states after the one that was answered last before it.
    Gains that make no stable error equation raise InputError.

    """
    found: list[Law] = []
    control, count = run.required_control, len(run.stamp)
    parameters = dict(control.parameters)
    for stamp, values in ((0, {}), *control.changes):
        parameters = {**parameters, **values}
        first = int(np.searchsorted(run.stamp, stamp, side='right')) if found else 0
        if found and not _LAW_PARAMETERS.intersection(values):
            continue
        if found and found[-1].first == first:
            found.pop()
        elif found:
            found[-1] = found[-1]._replace(end=first)
        gains = gains_from(parameters['kp'], parameters['kd'])
        found.append(Law(first, count, parameters, gains))
    return [law for law in found if law.first < law.end]


def promised_rows(laws: list[Law], count: int) -> np.ndarray:
    """Return which of ``count`` states are answered by computed torque, shape (count,)."""
    promised = np.zeros(count, dtype=bool)
    for law in laws:
        promised[law.first:law.end] = law.promised
    return promised


def law_active(run: Run) -> np.ndarray:
    """
    Return in which periods the law's command acted as it was sent, shape (n - 1,).

    Not where a state went unanswered, across a gap, beyond the torque limits, or, when not in
    lockstep, where the command came too late.

    """
    referenced = run.has_reference
    counted = run.steps & referenced[:-1] & referenced[1:]
    if run.command is None:
        return counted
    counted = counted & np.isfinite(run.command[:-1]).all(axis=1)
    if run.sim is None:
        return counted
    effort = run.exact.effort[1:]
    counted &= (np.abs(effort) < run.sim.arm.limits.effort).all(axis=1)
    if not run.sim.parameters['lockstep'] and (
            run.sim.parameters['effort_convention'] == 'total'):
        counted &= (np.abs(effort - run.command[:-1]) <= 1e-9).all(axis=1)
    return counted


def noise_allowance(run: Run) -> float:
    """
    Return by how much encoder noise may move e(t) [rad]; zero without noise.

    The law filters the noise: ten standard deviations of the position and ten of the velocity
    over a second bound what is left of it.

    """
    if run.sim is None:
        return 0.0
    parameters = run.sim.parameters
    return 10.0 * (parameters['noise.position'] + parameters['noise.velocity'] * 1.0)


def largest(values: np.ndarray) -> tuple[float, int, int]:
    """Return the largest magnitude of an (n, m) array, its column and row; NaN is left out."""
    size = np.abs(values)
    size[np.isnan(size)] = -1.0
    row, column = np.unravel_index(int(np.argmax(size)), size.shape)
    return float(size[row, column]), int(column), int(row)
