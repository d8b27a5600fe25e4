"""Tool motion to joint motion: inverse kinematics at every sample, one branch followed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ur5_ros.control.profiles import ToolSamples
from ur5_ros.control.trajectory import Sampled, grid
from ur5_ros.errors import InputError
from ur5_ros.model.inverse_kinematics import inverse_kinematics_batch
from ur5_ros.model.kinematics import jacobian, jacobian_rate
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, Reference

_TURN = 2.0 * np.pi
#: Samples of one branch lie closer than this, or the branch was lost [rad].
_LARGEST_STEP = 0.5
#: J has no inverse to any use nearer to a singularity, whatever margin is asked.
_LEAST_MARGIN = 1e-6


class Branch(NamedTuple):
    """One of the (at most eight) families of solutions, followed along a motion."""

    label: int
    """Column of :func:`~ur5_ros.model.inverse_kinematics.inverse_kinematics_batch`, 0 to 7."""
    candidates: int
    """How many columns held a solution where the motion began."""
    singularity: float
    """Least :func:`singularity_distance` on the way, or at a target."""

    @property
    def name(self) -> str:
        """The branch in words: shoulder left, right; elbow up, down; wrist plain, flipped."""
        return ', '.join((
            'shoulder ' + ('left', 'right')[self.label >> 2 & 1],
            'elbow ' + ('up', 'down')[self.label >> 1 & 1],
            'wrist ' + ('plain', 'flipped')[self.label & 1]))


def singularity_distance(q: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """
    Return how far from a singularity the arm is, as the smallest of three ratios.

    |sin q5| (wrist), |sin q3| (elbow), |X5| / (|a2| + |a3| + |d5|) (shoulder); their product is
    det J up to a constant, so zero means singular and no ratio exceeds one.

    ``q`` (..., 6): joint positions, manufacturer's angles [rad].  Returned: between 0 and 1,
    (...).
    """
    angles = q + arm.angle_offset
    wrist, elbow = np.sin(angles[..., 4]), np.sin(angles[..., 2])
    joint_3, joint_4 = angles[..., 1] + angles[..., 2], angles[..., 1:4].sum(axis=-1)
    shoulder = (arm.a[1] * np.cos(angles[..., 1]) + arm.a[2] * np.cos(joint_3)
                + arm.d[4] * np.sin(joint_4))
    reach = abs(arm.a[1]) + abs(arm.a[2]) + abs(arm.d[4])
    return np.minimum(np.minimum(np.abs(wrist), np.abs(elbow)), np.abs(shoulder) / reach)


def follow(
    samples: ToolSamples,
    times: np.ndarray,
    near: np.ndarray,
    arm: ArmParameters,
    margin: float,
) -> tuple[Reference, Branch]:
    """
    Return the joint motion of a tool motion, on the branch nearest to a configuration.

    q = IK(T), qd = J^-1 nu, qdd = J^-1 (dnu/dt - dJ/dt qd): consistent, nothing is differenced.

    ``times`` (n,): their times, for messages [s]; ``near`` (6,): configuration that the first
    sample should be nearest to, manufacturer's angles [rad].  Returned: joint motion in the
    manufacturer's angles, arrays of shape (n, 6).
    """
    solutions, valid = inverse_kinematics_batch(samples.pose, arm)
    solutions = solutions - arm.angle_offset
    label = _nearest_label(solutions[0], valid[0], near, arm)
    if label is None:
        raise _refused(0, times, 'is out of reach')
    q = _unwrapped(solutions[:, label], near, arm)
    distance = np.where(valid[:, label], singularity_distance(q, arm), 1.0)
    step = np.zeros(times.size)
    step[1:] = np.abs(np.diff(q, axis=0)).max(axis=1)
    margin = max(margin, _LEAST_MARGIN)
    bad = ~valid[:, label] | (distance < margin) | (step > _LARGEST_STEP)
    if bad.any():
        raise _refused(*_first_violation(bad, valid[:, label], distance, margin, times))
    reference = differentiate(q, samples, arm)
    check_limits(reference, times, arm)
    return reference, Branch(label, int(valid[0].sum()), float(distance.min()))


def tool_motion(
    samples_at: Callable[[np.ndarray], ToolSamples],
    duration: float,
    rate: int,
    near: np.ndarray,
    arm: ArmParameters,
    margin: float,
) -> tuple[Sampled, Branch]:
    """
    Return a tool motion as a joint motion, computed at once for every control period.

    ``samples_at``: times (n,) [s] to tool samples; ``duration``: length [s]; ``rate``: control
    periods a second [Hz]; ``near`` (6,): configuration that the first sample should be nearest to,
    manufacturer's angles [rad].
    """
    times = grid(duration, rate)
    table, branch = follow(samples_at(times), times, near, arm, margin)
    return Sampled(times, rate, table), branch


def differentiate(q: np.ndarray, samples: ToolSamples, arm: ArmParameters) -> Reference:
    """
    Return q with qd = J^-1 nu and qdd = J^-1 (dnu/dt - dJ/dt qd).

    ``q`` (n, 6): joint positions that reach the poses, away from singularities [rad].  Returned:
    joint motion, arrays of shape (n, 6).
    """
    model_angles = q + arm.angle_offset
    jac = jacobian(model_angles, arm)
    qd = np.linalg.solve(jac, samples.twist[..., None])
    bend = np.matmul(jacobian_rate(model_angles, qd[..., 0], arm), qd)
    qdd = np.linalg.solve(jac, samples.twist_rate[..., None] - bend)
    return Reference(q, qd[..., 0], qdd[..., 0])


def check_limits(reference: Reference, times: np.ndarray, arm: ArmParameters) -> None:
    """
    Refuse a motion that leaves the joint limits in position or speed.

    ``reference``: joint motion, arrays of shape (n, 6), manufacturer's angles; ``times`` (n,):
    their times, for messages [s].
    """
    limits = arm.limits
    beyond = ~((reference.q >= limits.lower) & (reference.q <= limits.upper))  # True for NaN
    too_fast = ~(np.abs(reference.qd) <= limits.velocity)
    bad = (beyond | too_fast).any(axis=1)
    if not bad.any():
        return
    i = int(bad.argmax())
    joint = int((beyond | too_fast)[i].argmax())
    name = JOINT_NAMES[joint]
    if beyond[i, joint]:
        raise _refused(i, times, f'needs {name} at {reference.q[i, joint]:.4f} rad; its limits '
                       f'are {limits.lower[joint]:.4f} to {limits.upper[joint]:.4f}')
    raise _refused(i, times, f'needs {name} at {abs(reference.qd[i, joint]):.3f} rad/s; its '
                   f'limit is {limits.velocity[joint]:.3f}: take more time')


def _nearest_label(
    solutions: np.ndarray,
    valid: np.ndarray,
    near: np.ndarray,
    arm: ArmParameters,
) -> int | None:
    """Return the branch of least squared distance, as nearest_solution chooses it."""
    if not valid.any():
        return None
    away = _nearest_turns(solutions, near, arm) - near
    return int(np.where(valid, (away * away).sum(axis=1), np.inf).argmin())


def _nearest_turns(q: np.ndarray, near: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """Return the angles by whole turns nearest to a configuration, in limits if possible."""
    q = q + _TURN * np.round((near - q) / _TURN)
    q = np.where(q > arm.limits.upper, q - _TURN, q)
    return np.where(q < arm.limits.lower, q + _TURN, q)


def _unwrapped(raw: np.ndarray, near: np.ndarray, arm: ArmParameters) -> np.ndarray:
    """Return the angles without turns between samples, the first nearest to ``near`` in limits."""
    turns = np.zeros(raw.shape)
    turns[0] = np.round((_nearest_turns(raw[0], near, arm) - raw[0]) / _TURN)
    turns[1:] = -np.round(np.diff(raw, axis=0) / _TURN)
    return raw + _TURN * np.cumsum(turns, axis=0)


def _first_violation(
    bad: np.ndarray,
    valid: np.ndarray,
    distance: np.ndarray,
    margin: float,
    times: np.ndarray,
) -> tuple[int, np.ndarray, str]:
    i = int(bad.argmax())
    if not valid[i]:
        return i, times, 'is out of reach on the branch followed'
    if distance[i] < margin:
        return i, times, (f'comes within {distance[i]:.4f} of a singularity; '
                          f'singularity_margin is {margin:g}')
    return i, times, 'would need a jump to another branch'


def _refused(i: int, times: np.ndarray, why: str) -> InputError:
    return InputError(f'sample {i + 1} of {times.size} (t = {times[i]:.3f} s) {why}')
