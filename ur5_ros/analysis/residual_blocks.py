"""The unexplained torque in blocks of samples, and what each cause would add to it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import PlantModel
from ur5_ros.analysis.residual import residual
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor

#: Blocks that are looked at, and periods a block: sums in which velocity noise cancels.
BLOCKS, BLOCK = 1500, 20

#: Length of a block where the states are measured ones [s].
SMOOTHING = 0.1

#: Speed below which the direction of dry friction is not told [rad/s].
SLOW = 1e-6


class SampleBlocks(NamedTuple):
    """Samples of a run, in blocks of consecutive periods: shapes (b, w, 6)."""

    q: np.ndarray
    """Angles of the model, offset added [rad]."""
    qd: np.ndarray
    qdd: np.ndarray
    qd_next: np.ndarray
    """Speed at the end of the period, at which friction acts [rad/s]."""
    effort: np.ndarray
    """Torque that acted [N m]."""
    unexplained_torque: np.ndarray
    """effort - inverse dynamics of the arm: what else the motion took [N m]."""
    plain: bool = False
    """Whether one period is one step of the plant, so that a true cause fits to rounding."""
    time: np.ndarray | None = None
    """Since the first state [s], shape (b, w)."""


def gather(run: Run, arm: ArmParameters, blocks: int = BLOCKS) -> SampleBlocks | None:
    """
    Return the evidence of a run against an arm; None where it is too short.

    Parameters
    ----------
    run : Run
        The recording; from a bag that does not know its plant's time step, the periods are taken
        as steps.
    arm : ArmParameters
        The arm of the law.
    blocks : int
        At most so many blocks are taken, evenly over the run.

    """
    whole = run.steps & np.isfinite(run.exact.effort[1:]).all(axis=1)
    if run.follows_reference:  # the reference brings its accelerations: gaps do no harm
        whole = np.isfinite(np.hstack([*run.reference, run.states.effort])).all(axis=1)[:-1]
    size = BLOCK
    if run.noisy or not run.substeps:
        size = max(2, round(SMOOTHING * run.control_rate))
    size = min(size, max(1, len(whole) // 50))
    starts = np.arange(0, len(whole) - size + 1, size)
    starts = starts[[whole[start:start + size].all() for start in starts]]
    if len(starts) < 10:
        return None
    starts = starts[np.unique(np.linspace(0, len(starts) - 1, blocks).astype(int))]
    rows = starts[:, None] + np.arange(size)
    q, qd, effort = run.exact
    if run.follows_reference:
        q, qd, qdd = (part[rows] for part in run.reference)
        return _evidence(q, qd, qdd, qd, effort[rows], arm)._replace(time=run.t[rows])
    qdd = (qd[rows + 1] - qd[rows]) * run.control_rate
    if not run.substeps:
        # Nobody says when between two states a torque acted: take the middle of everything.
        middle = 0.5 * (qd[rows] + qd[rows + 1])
        return _evidence(0.5 * (q[rows] + q[rows + 1]), middle, qdd, middle,
                         0.5 * (effort[rows] + effort[rows + 1]), arm)._replace(
                             time=run.t[rows])
    seen = _evidence(q[rows], qd[rows], qdd, qd[rows + 1], effort[rows + 1], arm)
    if run.substeps > 1:
        unexplained_torque = -residual(run, [(0, PlantModel(arm))]).torque[rows]
        return seen._replace(unexplained_torque=np.nan_to_num(unexplained_torque),
                             time=run.t[rows])
    return seen._replace(plain=not run.noisy, time=run.t[rows])


def _evidence(q, qd, qdd, qd_next, effort, arm: ArmParameters) -> SampleBlocks:
    angles = q + arm.angle_offset
    return SampleBlocks(angles, qd, qdd, qd_next, effort,
                    effort - inverse_dynamics(angles, qd, qdd, arm))


def effects(seen: SampleBlocks, arm: ArmParameters) -> dict[str, np.ndarray]:
    """
    Return the torque that a unit of each cause adds, block means: name -> (b, 6, parameters).

    Parameters
    ----------
    seen : SampleBlocks
        Samples.
    arm : ArmParameters
        The arm of the law.

    Returns
    -------
    dict
        ``payload`` (ten inertial parameters about the tool), ``viscous friction``, ``Coulomb
        friction``, ``armature`` (six each), ``gravity`` (three).

    """
    load = dynamics_regressor(seen.q, seen.qd, seen.qdd, arm)[..., 50:]
    fields = [_with_gravity(arm, axis) for axis in np.eye(3)]
    field = np.stack([gravity_torque(seen.q, each) for each in fields], axis=-1)
    return {
        'payload': load.mean(axis=1),
        'viscous friction': _diagonal(seen.qd_next),
        'Coulomb friction': _diagonal(np.sign(seen.qd_next)),
        'armature': _diagonal(seen.qdd),
        'gravity': field.mean(axis=1),
    }


def sliding(seen: SampleBlocks) -> np.ndarray:
    """Tell in which blocks each joint keeps moving one way, so that its friction is known."""
    return (np.abs(seen.qd_next) > SLOW).all(axis=1)


def _diagonal(values: np.ndarray) -> np.ndarray:
    mean = values.mean(axis=1)
    return mean[:, :, None] * np.eye(6)


def _with_gravity(arm: ArmParameters, gravity: np.ndarray) -> ArmParameters:
    return replace(arm, gravity=np.array(gravity, dtype=float))
