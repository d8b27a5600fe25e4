"""The unexplained torque in blocks of samples, and the torque that a unit of each cause adds."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import law_model
from ur5_ros.analysis.residual import residual
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor

#: Blocks that are taken of a run, and periods a block: sums in which velocity noise cancels.
BLOCKS, BLOCK = 1500, 20

#: Length of a block where the states are measured ones [s].
BLOCK_TIME = 0.1

#: Fewer blocks are no evidence.
LEAST_BLOCKS = 10

#: Speed below which the direction of dry friction is not known [rad/s]: of exact states, and of
#: measured ones, which have to move by so many times their noise besides.
SLOW_SPEED, SLOW_MEASURED, NOISES = 1e-6, 5e-3, 4.0


#: Torque is noise alone below this many times what differs from block to block.
NOISE_ALONE = 2.0

#: Parts of the samples that are no arrays.
FLAGS = ('exact', 'measured')


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
    time: np.ndarray
    """Since the first state [s], shape (b, w)."""
    exact: bool = False
    """Whether one period is one step of the plant, so that a true cause fits to rounding."""
    measured: bool = False
    """Whether the states are those of sensors, with noise."""

    def rows(self, rows: slice | np.ndarray) -> 'SampleBlocks':
        """Return some of the blocks."""
        return self._replace(**{name: getattr(self, name)[rows]
                                for name in self._fields if name not in FLAGS})


def sample_blocks(run: Run, arm: ArmParameters, blocks: int = BLOCKS) -> SampleBlocks | None:
    """
    Return at most ``blocks`` blocks of a run, evenly spread; None where it is too short.

    Where the plant's time step is not known, the periods are taken as steps and everything in
    the middle between two states; where the effort is a robot's target torque, the reference is
    the motion.

    """
    whole = run.steps & np.isfinite(run.exact.effort[1:]).all(axis=1)
    if run.follows_reference:  # the reference has its own accelerations: gaps do no harm
        whole = run.has_reference[:-1] & np.isfinite(run.states.effort).all(axis=1)[:-1]
    size = BLOCK
    if run.noisy or not run.substeps:
        size = max(2, round(BLOCK_TIME * run.control_rate))
    size = min(size, max(1, len(whole) // 50))
    starts = np.arange(0, len(whole) - size + 1, size)
    starts = starts[[whole[start:start + size].all() for start in starts]]
    if len(starts) < LEAST_BLOCKS:
        return None
    starts = starts[np.unique(np.linspace(0, len(starts) - 1, blocks).astype(int))]
    return _samples(run, arm, starts[:, None] + np.arange(size))._replace(measured=run.noisy)


def _samples(run: Run, arm: ArmParameters, rows: np.ndarray) -> SampleBlocks:
    """Return the samples of these rows, shape (b, w)."""
    q, qd, effort = run.exact
    if run.contact is not None:
        effort = effort + run.contact.mean(axis=1)
    if run.follows_reference:
        q, qd, qdd = (part[rows] for part in run.required_reference)
        return _against(arm, q, qd, qdd, qd, effort[rows], run.t[rows])
    if run.effort_meaning == 'target':  # of a reference at rest
        rest = np.zeros((*rows.shape, 6))
        return _against(arm, q[rows], rest, rest, rest, effort[rows], run.t[rows])
    if not run.substeps:
        qdd = (qd[rows + 1] - qd[rows]) / np.diff(run.t)[rows][..., None]
        middle = 0.5 * (qd[rows] + qd[rows + 1])
        return _against(arm, 0.5 * (q[rows] + q[rows + 1]), middle, qdd, middle,
                        0.5 * (effort[rows] + effort[rows + 1]), run.t[rows])
    qdd = (qd[rows + 1] - qd[rows]) * run.control_rate
    found = _against(arm, q[rows], qd[rows], qdd, qd[rows + 1], effort[rows + 1], run.t[rows])
    model = law_model(run, arm)
    if run.substeps > 1 or not model.friction.none:
        defect = residual(run, [(0, model)]).torque[rows]
        found = found._replace(unexplained_torque=np.nan_to_num(-defect))
    if run.substeps > 1:
        return found
    return found._replace(exact=not run.noisy)


def _against(arm: ArmParameters, q, qd, qdd, qd_next, effort, time) -> SampleBlocks:
    angles = q + arm.angle_offset
    return SampleBlocks(angles, qd, qdd, qd_next, effort,
                        effort - inverse_dynamics(angles, qd, qdd, arm), time)


def unit_torques(samples: SampleBlocks, arm: ArmParameters) -> dict[str, np.ndarray]:
    """
    Return the torque that a unit of each cause adds, block means: name -> (b, 6, parameters).

    ``payload`` (ten inertial parameters about the tool), ``viscous friction``, ``Coulomb
    friction``, ``load-dependent friction``, ``armature`` (six each), ``gravity`` (three).

    """
    load = dynamics_regressor(samples.q, samples.qd, samples.qdd, arm)[..., 50:]
    fields = [replace(arm, gravity=axis) for axis in np.eye(3)]
    field = np.stack([gravity_torque(samples.q, each) for each in fields], axis=-1)
    return {
        'payload': load.mean(axis=1),
        'viscous friction': _diagonal(samples.qd_next),
        'Coulomb friction': _diagonal(np.sign(samples.qd_next)),
        'load-dependent friction': _diagonal(
            np.sign(samples.qd_next) * np.abs(load_torque(samples, arm))),
        'armature': _diagonal(samples.qdd),
        'gravity': field.mean(axis=1),
    }


def load_torque(samples: SampleBlocks, arm: ArmParameters) -> np.ndarray:
    """Return the torque that the joints transmit without acceleration, (b, w, 6) [N m]."""
    return inverse_dynamics(samples.q, samples.qd, np.zeros(samples.qd.shape), arm)


def stribeck_torque(samples: SampleBlocks, velocity: float) -> np.ndarray:
    """Return what a unit of friction adds that decays to 1/e at a speed [rad/s], (b, 6, 6)."""
    return _diagonal(np.sign(samples.qd_next) * np.exp(-np.square(samples.qd / velocity)))


def sticking(samples: SampleBlocks) -> np.ndarray:
    """Return in which samples a joint stands still throughout, (b, w, 6)."""
    return (np.abs(samples.qd_next) <= SLOW_SPEED) & (np.abs(samples.qd) <= SLOW_SPEED)


def sliding(samples: SampleBlocks) -> np.ndarray:
    """
    Return in which blocks each joint keeps moving, so that its friction is known, (b, 6).

    A block beside one in which it stands is left out: friction of rest begins and ends there. In
    measured states a joint moves that is faster than their noise in one direction.

    """
    if samples.measured:
        mean = samples.qd.mean(axis=1)
        noise = velocity_noise(samples)
        ahead = np.min(np.sign(mean)[:, None] * samples.qd, axis=1)
        return (np.abs(mean) > np.maximum(SLOW_MEASURED, NOISES * noise)) & (
            ahead > -NOISES * noise)
    stands = (np.abs(samples.qd_next) <= SLOW_SPEED).any(axis=1)
    beside = stands.copy()
    beside[1:] |= stands[:-1]
    beside[:-1] |= stands[1:]
    return ~beside


def velocity_noise(samples: SampleBlocks) -> np.ndarray:
    """Return the standard deviation of the noise of each velocity, (6,) [rad/s]."""
    if samples.qd.shape[1] < 3:
        return np.zeros(6)
    turns = np.diff(samples.qd, 2, axis=1)
    return np.sqrt(np.mean(turns**2, axis=(0, 1)) / 6.0)


def is_noise(torque: np.ndarray) -> np.ndarray:
    """Return whether block means (b, 6) are without a connection in time, by joint (6,)."""
    turns = torque[:-2] - 2.0 * torque[1:-1] + torque[2:]
    noise = np.sqrt(np.mean(turns**2, axis=0) / 6.0)
    return np.sqrt(np.mean(torque**2, axis=0)) < NOISE_ALONE * noise


def _diagonal(values: np.ndarray) -> np.ndarray:
    """Return block means on the diagonals of 6 x 6 matrices."""
    return values.mean(axis=1)[:, :, None] * np.eye(6)
