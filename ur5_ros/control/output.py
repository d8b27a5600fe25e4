"""The output of the controller for a state, and its status in words and numbers."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.control.execution import TrajectoryExecutor
from ur5_ros.control.tool_motion import singularity_distance
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

WAITING = 'waiting for states'
HOLDING = 'holding'
MOVING = 'moving'
REFUSED = 'refused'
STOPPED = 'stopped by a limit'


class ControlOutput(NamedTuple):
    """The output for one state."""

    stamp: int
    """Stamp of the state answered [ns]."""
    parts: np.ndarray
    """The command and its parts, rows as :class:`ur5_ros.signals.Torque` names them, (5, 6)."""
    reference: Reference
    """The reference at this stamp."""
    status: str
    """The state of the controller in words."""
    limited: str
    """'' or the limits that scaled the torque: 'effort', 'rate' or 'effort, rate'."""

    @property
    def torque(self) -> Torque:
        """The command and its parts, by name [N m]."""
        return Torque(*self.parts)


def status_of(waiting: bool, stopped: str, moving: bool, refused: str) -> str:
    """Return the state of the controller in words; ``stopped`` and ``refused`` are reasons."""
    if waiting:
        return WAITING
    if stopped:
        return STOPPED
    if moving:
        return MOVING
    return REFUSED if refused else HOLDING


def describe(
    output: ControlOutput | None,
    state: ArmState | None,
    executor: TrajectoryExecutor,
    arm: ArmParameters,
    mode: str,
) -> dict[str, Any]:
    """
    Return the numbers of the last output.

    ``output``: None before the first state.  Returned: stamp [ns], chosen inverse-kinematics
    branch, number of candidates and least distance to singularity on the way (0 to 1), that of the
    arm now, largest joint error [rad], time left of the motion [s], limits that act, whether the
    inverse of J is limited.
    """
    if output is None or state is None:
        return {'stamp': 0}
    branch = executor.branch
    left = executor.start + executor.trajectory.duration - output.stamp
    return {
        'stamp': output.stamp,
        'ik_branch': '' if branch is None else branch.name,
        'ik_candidates': 0 if branch is None else branch.candidates,
        'ik_singularity_distance': 1.0 if branch is None else branch.singularity,
        'singularity_distance': float(singularity_distance(state.q, arm)),
        'largest_error': float(np.abs(state.q - output.reference.q).max()),
        'seconds_left': max(0, left) / 1e9,
        'torque_limited': output.limited,
        'inverse_limited': mode == 'cartesian_impedance' and _inverse_is_limited(state.q, arm),
    }


def _inverse_is_limited(q: np.ndarray, arm: ArmParameters) -> bool:
    from ur5_ros.control.laws.cartesian_impedance import inverse_is_limited  # there with its law
    return inverse_is_limited(q, arm)
