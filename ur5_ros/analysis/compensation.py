"""What the simulated robot adds to a command by itself: friction compensation, from the bag."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.config.friction import joint_friction
from ur5_ros.model.friction import friction_compensation

_SCALES = ('friction_compensation.viscous_scale', 'friction_compensation.coulomb_scale')


def robot_compensation(run: Run) -> np.ndarray | None:
    """
    Return what the robot adds against its friction in each period, (n - 1, 6) [N m].

    It comes from the measured speed of the state before; None where nothing is added.

    """
    if run.sim is None:
        return None
    torque = np.zeros((len(run.stamp) - 1, 6))
    for first, last, values in _stretches(run):
        viscous, coulomb = (np.array(values.get(name, [0.0] * 6), dtype=float)
                            for name in _SCALES)
        if viscous.any() or coulomb.any():
            torque[first:last] = friction_compensation(
                joint_friction(values), run.states.qd[:-1][first:last], viscous, coulomb)
    return torque if torque.any() else None


def _stretches(run: Run) -> Iterator[tuple[int, int, Mapping[str, Any]]]:
    """Yield first row, last row and parameters of friction between two changes of them."""
    values, first = dict(run.required_sim.parameters), 0
    for event in run.events:
        name = event.values.get('name', '') if event.kind == 'parameter' else ''
        if str(name).startswith('friction'):
            last = int(np.searchsorted(run.stamp, event.stamp))
            yield first, last, values
            values, first = values | {name: event.values['value']}, last
    yield first, len(run.stamp), values
