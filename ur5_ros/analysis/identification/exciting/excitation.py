"""An excitation trajectory: finite Fourier series with a small condition number, within limits."""

import time as clock
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.identification.base_parameters import (
    base_of,
    inertial_columns,
)
from ur5_ros.analysis.identification.exciting.clearance import clearance_of
from ur5_ros.config.experiments import JointWaves, Wave
from ur5_ros.control.profiles import window
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES, Reference

#: States a second at which the condition number is taken, and those at which limits are kept [Hz].
RATE, LIMIT_RATE = 8.0, 50.0

#: Noise of the torque: samples a second [Hz], and its size as a share of the largest torque.
NOISE_RATE, NOISE = 100.0, 0.01

#: Share of a joint's limits in speed and torque that is used.
USED_SHARE = 0.9

#: Widest swing about the start [rad].
WIDEST_SWING = 2.4

#: Speed over which dry friction changes its direction in the condition number [rad/s].
DIRECTION_SPEED = 0.02

#: Share of the time spent on random series, and series that are then refined.
RANDOM_SHARE, REFINED = 0.15, 3

#: Weight of a broken limit against the logarithm of the condition number, and how far from one the
#: search stays, whose states are few.
PENALTY, MARGIN = 10.0, 0.1


#: How the trajectory was found, for its file.
SOURCE = ('smallest condition numbers of the regressor of base parameters and friction, in SI '
          'units and with columns at length one, that were found within the limits')


class Excitation(NamedTuple):
    """The trajectory that was found."""

    experiment: JointWaves
    """As an experiment of ``config/experiments``."""
    condition: float
    """Condition number of the regressor, columns scaled to length one."""
    condition_raw: float
    """The same in SI units, columns as they are."""
    names: tuple[str, ...]
    """Base parameters, then viscous and Coulomb friction of each joint."""
    error: np.ndarray
    """Standard error of each that torque noise makes, shape (p,)."""
    noise: np.ndarray
    """The noise [N m]: standard deviation of one sample at 100 Hz, shape (6,)."""
    tried: int
    """How many series were tried."""


class _Problem:
    """Everything about the series of an arm that does not change while it is searched."""

    def __init__(self, arm: ArmParameters, seconds: float, harmonics: int, ramp: float,
                 acceleration: float, clearance: float):
        self.arm, self.base = arm, base_of(arm)
        self.seconds, self.harmonics, self.ramp = seconds, harmonics, ramp
        self.clearance = clearance
        t = np.arange(0.0, seconds, 1.0 / LIMIT_RATE)
        self.basis = _basis(t, seconds, harmonics, ramp)
        self.every = round(LIMIT_RATE / RATE)
        limits = arm.limits
        self.speed, self.acceleration = USED_SHARE * limits.velocity, np.full(6, acceleration)
        self.lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi) + 0.05
        self.upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi) - 0.05

    def motion(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, Reference]:
        """Return start (6,), coefficients (2h, 6), and the motion of a point of the search."""
        start, share, free = z[:6], np.clip(z[6:12], 0.05, 1.0), z[12:].reshape(-1, 6)
        swing, rate, change = (part @ free for part in self.basis)
        half = np.minimum(WIDEST_SWING, np.minimum(start - self.lower, self.upper - start))
        # each joint takes its share of what position, speed and acceleration let it have
        most = np.max([np.abs(swing).max(axis=0) / np.maximum(half, 1e-3),
                       np.abs(rate).max(axis=0) / self.speed,
                       np.abs(change).max(axis=0) / self.acceleration], axis=0)
        scale = share / np.maximum(most, 1e-9)
        return start, free * scale, Reference(start + swing * scale, rate * scale,
                                              change * scale)

    def cost(self, z: np.ndarray) -> float:
        """Return the mean logarithm of both condition numbers, broken limits added."""
        _, _, motion = self.motion(z)
        part = Reference(*(values[::self.every] for values in motion))
        x = self.columns(part)
        # scaled columns alone would be as well conditioned however little a joint moves
        both = 0.5 * (_log_condition(x) + _log_condition(scaled_columns(x)))
        return both + PENALTY * self.broken(part, MARGIN)

    def columns(self, motion: Reference) -> np.ndarray:
        """Return the regressor of base parameters and friction, shape (n * 6, p)."""
        angles = motion.q + self.arm.angle_offset
        inertial = inertial_columns(angles, motion.qd, motion.qdd, self.arm)
        friction = [value[..., None] * np.eye(6) for value in
                    (motion.qd, np.tanh(motion.qd / DIRECTION_SPEED))]
        x = np.concatenate([inertial[..., self.base.columns], *friction], axis=-1)
        return x.reshape(-1, x.shape[-1])

    def broken(self, motion: Reference, margin: float = 0.0) -> float:
        """Return by which share torque and clearance are broken; 0 = not at all."""
        angles = motion.q + self.arm.angle_offset
        torque = np.abs(inverse_dynamics(angles, motion.qd, motion.qdd, self.arm))
        over = float((torque / (USED_SHARE * self.arm.limits.effort)).max()) - 1.0
        near = float(1.0 - clearance_of(angles, self.arm).min() / self.clearance)
        return max(over + margin, 0.0) + max(near + margin, 0.0)


def excite(
    arm: ArmParameters, seconds: float = 30.0, budget: float = 120.0, harmonics: int = 8,
    acceleration: float = 4.0, clearance: float = 0.12, seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Excitation:
    """
    Search the Fourier series whose regressor has the smallest condition numbers within limits.

    Random series first, then the best of them refined by an evolution strategy with the 1/5
    success rule (Rechenberg 1973).  The condition number of the regressor bounds how noise of the
    torque becomes error of the parameters (Swevers et al. 1997).

    ``seconds``: length of the motion [s]; it begins and ends at rest; ``budget``: time of this
    process that the search may take [s]; ``acceleration``: largest joint acceleration [rad/s^2];
    ``clearance``: least distance of elbow, wrists and tool from the table plane, and of wrists and
    tool from upper arm and base column [m].
    """
    if not 4.0 <= seconds <= 600.0:
        raise InputError(f'seconds is {seconds:g}; give 4 to 600')
    if not budget > 0.0:
        raise InputError(f'budget is {budget:g} s; give more than zero')
    if not acceleration > 0.0:
        raise InputError(f'acceleration is {acceleration:g} rad/s^2; give more than zero')
    ramp = min(2.0, seconds / 8.0)
    problem = _Problem(arm, seconds, harmonics, ramp, acceleration, clearance)
    random = np.random.default_rng(seed)
    z, tried = _search(problem, budget, random, progress)
    start, free, motion = problem.motion(z)
    if problem.broken(motion) > 0.0:
        raise InputError(f'no motion of arm {arm.name} within its limits was found in '
                         f'{budget:g} s; give more --budget, or less --clearance')
    x = problem.columns(motion)
    names = (*problem.base.names, *(f'{what} {name}' for what in ('viscous', 'Coulomb')
                                    for name in JOINT_NAMES))
    noise = NOISE * arm.limits.effort
    return Excitation(_experiment(arm, seconds, ramp, start, free),
                      float(np.linalg.cond(scaled_columns(x))), float(np.linalg.cond(x)), names,
                      predicted_errors(x, noise), noise, tried)


def predicted_errors(x: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """
    Return the standard errors of least squares under white torque noise.

    ``x`` (n * 6, p): regressor, six rows a state, at :data:`LIMIT_RATE`; ``noise`` (6,): standard
    deviation of one torque sample at :data:`NOISE_RATE` [N m].
    """
    rows = x / np.tile(noise, len(x) // 6)[:, None]
    size = np.linalg.norm(rows, axis=0)
    inverse = np.linalg.pinv((rows / size).T @ (rows / size), hermitian=True)
    return np.sqrt(np.diag(inverse) * LIMIT_RATE / NOISE_RATE) / size


def _log_condition(x: np.ndarray) -> float:
    value = np.linalg.eigvalsh(x.T @ x)
    return float(0.5 * np.log(value[-1] / max(value[0], 1e-14 * value[-1])))


def scaled_columns(x: np.ndarray) -> np.ndarray:
    """Return the columns at length one."""
    size = np.linalg.norm(x, axis=0)
    return x / np.where(size > 0.0, size, 1.0)


def _basis(t: np.ndarray, seconds: float, harmonics: int, ramp: float) -> list[np.ndarray]:
    """Return sines and cosines with the ramps of the experiment, and derivatives, (n, 2h) each."""
    weight = window(t, seconds, ramp, ramp)
    columns = []
    for k in range(1, harmonics + 1):
        omega = 2.0 * np.pi * k / seconds
        for phase in (0.0, 0.5 * np.pi):
            value = np.sin(omega * t + phase)
            rate = omega * np.cos(omega * t + phase)
            columns.append((
                weight.value * value, weight.rate * value + weight.value * rate,
                weight.acceleration * value + 2.0 * weight.rate * rate
                - weight.value * omega**2 * value))
    return [np.stack(part, axis=-1) for part in zip(*columns, strict=True)]


def _search(problem: _Problem, budget: float, random: np.random.Generator, progress):
    """Return the best point that the budget lets us find, and how many were tried."""
    begin, tried = clock.monotonic(), 0
    found: list[tuple[float, np.ndarray]] = []
    while clock.monotonic() - begin < RANDOM_SHARE * budget or not found:
        z = _random_point(problem, random)
        found = sorted([*found, (problem.cost(z), z)], key=lambda each: each[0])[:REFINED]
        tried += 1
        if progress and tried % 20 == 0:
            progress((clock.monotonic() - begin) / budget)
    best = found[0]
    for turn, (cost, z) in enumerate(found):
        share = RANDOM_SHARE + (1.0 - RANDOM_SHARE) * (turn + 1) / len(found)
        step = 0.1
        while clock.monotonic() - begin < share * budget:
            trial = z + step * random.standard_normal(z.size) * (
                random.random(z.size) < max(0.15, 4.0 / z.size))
            trial[:6] = np.clip(trial[:6], problem.lower + 0.2, problem.upper - 0.2)
            value = problem.cost(trial)
            tried += 1
            if value < cost:
                cost, z, step = value, trial, min(step * 1.5, 0.5)
            else:
                step = max(step * 0.904, 1e-4)  # 1.5 x 0.904^4 = 1: one success in five
            if progress and tried % 20 == 0:
                progress((clock.monotonic() - begin) / budget)
        best = min(best, (cost, z), key=lambda each: each[0])
    return best[1], tried


def _random_point(problem: _Problem, random: np.random.Generator) -> np.ndarray:
    """Return a start about the usual pose, and coefficients that fall with the harmonic."""
    home = np.radians([0.0, -80.0, 80.0, -90.0, -90.0, 0.0])
    start = np.clip(home + random.uniform(-0.6, 0.6, 6), problem.lower + 0.2,
                    problem.upper - 0.2)
    order = np.repeat(np.arange(1, problem.harmonics + 1), 2)[:, None]
    free = random.standard_normal((2 * problem.harmonics, 6)) / order
    return np.concatenate([start, random.uniform(0.2, 0.9, 6), free.ravel()])


def _experiment(arm: ArmParameters, seconds: float, ramp: float, start: np.ndarray,
                free: np.ndarray) -> JointWaves:
    """Return the series as an experiment: a sin + b cos = amplitude sin(. + phase)."""
    sine, cosine = free[0::2], free[1::2]
    amplitude = np.hypot(sine, cosine)
    phase = np.degrees(np.arctan2(cosine, sine)) % 360.0
    joints: dict[Any, list[Wave]] = {
        name: [Wave(amplitude=float(amplitude[k, j]), frequency=(k + 1) / seconds,
                    phase_degrees=float(phase[k, j])) for k in range(len(sine))]
        for j, name in enumerate(JOINT_NAMES)}
    return JointWaves(
        name='excitation', description=f'Fourier series that excites arm {arm.name}, for the '
        'identification of inertial and friction parameters.',
        source=f'ur5 excite: {SOURCE}', kind='joint_waves', duration=seconds, ramp=ramp,
        ramp_down=ramp, start_degrees=np.degrees(start).tolist(), joints=joints)
