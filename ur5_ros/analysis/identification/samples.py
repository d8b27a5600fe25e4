"""What a run holds for identification: motion and torque, period by period, as measured."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters

#: Speed under which the direction of dry friction is not determined [rad/s]: of measured states,
#: and of states without noise from a plant whose time step is the period.
SLOW_SPEED, SLOW_EXACT = 5e-3, 1e-6

#: Time over which measured speeds are averaged for their direction [s].
DIRECTION_TIME = 0.02

#: Steps of recorded time that belong together, in periods.
SHORTEST, LONGEST = 0.05, 2.5


#: Temperatures that vary by less explain nothing [K].
LEAST_WARMING = 1.0


class Samples(NamedTuple):
    """Consecutive periods without a gap; every array of shape (n, 6) if not stated otherwise."""

    time: np.ndarray
    """Since the first state of the run [s], shape (n,)."""
    q: np.ndarray
    """Angles of the model, offset added [rad]."""
    qd: np.ndarray
    qdd: np.ndarray
    speed: np.ndarray
    """Speed at which friction acts [rad/s]."""
    direction: np.ndarray
    """Direction of dry friction, -1 to 1."""
    slow: np.ndarray
    """Whether the speed is too small for a direction."""
    effort: np.ndarray
    """Torque that acted [N m]."""
    current: np.ndarray | None
    """Motor current [A]."""
    warmer: np.ndarray | None
    """Temperature above the mean one of the recordings [K]."""
    exact: bool
    """Whether one period is one step of the plant, without noise."""


def mean_temperature(runs: Sequence[Run]) -> np.ndarray | None:
    """Return the mean temperature of the joints [deg C], (6,); None where a run has none."""
    known = [run.temperature for run in runs if run.temperature is not None]
    return np.concatenate(known).mean(axis=0) if len(known) == len(runs) else None


def samples_of(run: Run, arm: ArmParameters,
               temperature: np.ndarray | None = None) -> list[Samples]:
    """
    Return the stretches of a run without a gap, as measured.

    States as published are used, never the exact ones beside them.  Where the bag states how the
    plant steps, each quantity is taken at the time at which the plant used it; elsewhere in the
    middle of the period.  Of motor currents alone the torque is that of the arm.
    ``temperature``: the mean one of the joints [deg C], (6,).
    """
    if np.isnan(run.states.effort).all() and run.current is None:
        raise InputError(f'{run.name}: no torques are recorded, and no motor currents; one of '
                         'them is needed')
    noisy = run.truth is not None or run.noisy
    if run.follows_reference:
        time, motion = run.t, [*run.required_reference, run.states.effort]
        speed, current = run.required_reference.qd, run.current
        whole = np.isfinite(np.hstack(motion)).all(axis=1)
        q, qd, qdd, effort = motion
    else:
        time, q, qd, qdd, speed = _between_states(run)
        effort = (inverse_dynamics(q + arm.angle_offset, qd, qdd, arm) if has_currents_alone(run)
                  else _acting(run, run.states.effort))
        current = None if run.current is None else _acting(run, run.current)
        whole = np.isfinite(np.hstack([q, qd, qdd, effort])).all(axis=1) & _follow(run)
    if _is_of_standing_reference(run):
        qd, qdd, speed = np.zeros_like(qd), np.zeros_like(qdd), np.zeros_like(speed)
    warmer = None
    if temperature is not None and run.temperature is not None:
        warmer = run.temperature[:len(q)] - temperature
        if np.ptp(warmer, axis=0).max() < LEAST_WARMING:
            warmer = None
    exact = not noisy and run.substeps == 1
    slow = SLOW_EXACT if exact else SLOW_SPEED
    parts = []
    for rows in _stretches(whole):
        v = speed[rows]
        mean = v if exact else moving_average(v, round(DIRECTION_TIME * run.control_rate))
        parts.append(Samples(
            time[rows], q[rows] + arm.angle_offset, qd[rows], qdd[rows], v,
            np.sign(v) if exact else np.clip(mean / slow, -1.0, 1.0), np.abs(mean) < slow,
            effort[rows], None if current is None else current[rows],
            None if warmer is None else warmer[rows], exact))
    return parts


def has_currents_alone(run: Run) -> bool:
    """Return whether a run has motor currents and no torque."""
    return run.current is not None and bool(np.isnan(run.states.effort).all())


def moving_average(values: np.ndarray, length: int) -> np.ndarray:
    """Return the mean over ``length`` rows about each row, made odd, shape as given."""
    half = min(length, len(values)) // 2
    if not half:
        return values
    total = np.cumsum(np.pad(values, ((half + 1, half), (0, 0)), 'edge'), axis=0)
    return (total[2 * half + 1:] - total[:-2 * half - 1]) / (2 * half + 1)


def _is_of_standing_reference(run: Run) -> bool:
    """Return whether the torque is that of gravity alone: a robot guided by hand computes so."""
    if run.effort_meaning == 'target':
        return True
    if not run.follows_reference:
        return False
    star = run.required_reference
    return not np.nan_to_num(star.qdd).any() and bool(np.nan_to_num(star.qd).any())


def _between_states(run: Run):
    """Return time, q, qd, qdd and friction's speed of each period, (n - 1, 6)."""
    q, qd, _ = run.states
    if run.substeps:
        # Of n steps the mean begins (n - 1)/2n into the period; friction is at the end of each.
        begin, end = ((run.substeps + sign) / (2.0 * run.substeps) for sign in (-1, 1))
    else:
        begin = end = 0.5
    seconds = np.diff(run.stamp) * 1e-9
    if run.sim is not None:
        seconds = np.full(len(seconds), run.h)
    with np.errstate(divide='ignore', invalid='ignore'):
        qdd = np.diff(qd, axis=0) / seconds[:, None]
    return run.t[:-1], _between(q, begin), _between(qd, begin), qdd, _between(qd, end)


def _acting(run: Run, values: np.ndarray) -> np.ndarray:
    """Return what acted in each period; a plant's bag has it with the state that ends it."""
    return values[1:] if run.substeps else _between(values, 0.5)


def _between(values: np.ndarray, share: float) -> np.ndarray:
    return (1.0 - share) * values[:-1] + share * values[1:]


def _follow(run: Run) -> np.ndarray:
    """Return which states are followed by the next one, a robot's own clock taken as it is."""
    if run.sim is not None:
        return run.steps
    periods = np.diff(run.stamp) * 1e-9 * run.control_rate
    return (periods > SHORTEST) & (periods < LONGEST)


def _stretches(whole: np.ndarray) -> list[slice]:
    """Return where ``whole`` stays true, as slices."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], whole.astype(int), [0]])))
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)]
