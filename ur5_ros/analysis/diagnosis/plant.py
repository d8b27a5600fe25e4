"""Causes in the plant: payload, friction, rotor inertia, gravity, another arm; fitted."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.residual_blocks import (
    SampleBlocks,
    sample_blocks,
    sliding,
    unit_torques,
)
from ur5_ros.config import list_arms, load_arm
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: A cause must explain this share of the unexplained torque, squared; more where the plant's time
#: step is not that of the recording, or there is noise.
SHARE_EXACT, SHARE_MEASURED = 1e-6, 1e-3

#: What a true cause leaves at most in exact samples.
ROUNDING = 1e-12

#: Smallest standard error, as a share of the value: the model is not known better.
PRECISION = 1e-9

#: A cause must explain this many times the noise.
MIN_SIGNAL = 40.0

#: Number of standard errors from which on a value is significant.
SIGNIFICANT = 5.0

_UNITS = {'viscous friction': 'N m s/rad', 'Coulomb friction': 'N m', 'armature': 'kg m^2'}


class Fit(NamedTuple):
    """Causes fitted together."""

    names: tuple[str, ...]
    value: np.ndarray
    """All parameters, cause after cause."""
    error: np.ndarray
    """Their standard errors."""
    left: float
    """What stays unexplained, squared, as a share of everything."""
    confounders: tuple[str, ...] = ()
    """Causes that are not needed, but that this motion does not separate from those found."""


def plant_causes(run: Run, arm: ArmParameters) -> list[dict[str, Any]]:
    """
    Return what in the plant the law's arm does not have, most important first.

    Each has ``kind``, ``sentence``, ``share`` of the squared residual that is explained, and
    sizes with errors.

    """
    samples = sample_blocks(run, arm)
    if samples is None or not np.abs(samples.unexplained_torque).max() > 0.0:
        return []
    units = unit_torques(samples, arm)
    unexplained_torque = samples.unexplained_torque.mean(axis=1)
    known = sliding(samples)
    scale = np.sqrt(np.mean(unexplained_torque**2, axis=0))
    scale = np.maximum(scale, 1e-6 * scale.max())
    weight = known / scale / np.sqrt(known.sum())
    weight = np.where(known.any(axis=0), weight, 0.0)
    least = SHARE_EXACT if samples.exact else SHARE_MEASURED
    fit = _choose(units, unexplained_torque, weight, least)
    if not samples.exact:
        fit = _with_confounders(fit, units, unexplained_torque, weight)
    other, left = _best_arm(samples, arm, weight)
    if other and left < 0.1 and fit.left > ROUNDING and (
            left < 0.5 * fit.left or left < 1.05 * fit.left and len(fit.names) > 2):
        parts = _sentences(fit, arm) if set(fit.names) <= {'armature', 'gravity'} else []
        return [_arm_cause(other, arm, 1.0 - left), *parts]
    return _sentences(fit, arm)


def _choose(units, unexplained_torque, weight, least: float) -> Fit:
    """Add the best cause as long as it is significant, then drop those that no longer are."""
    chosen: tuple[str, ...] = ()
    best = _fit(units, chosen, unexplained_torque, weight)
    while len(chosen) < len(units):
        trials = [_fit(units, (*chosen, name), unexplained_torque, weight)
                  for name in units if name not in chosen]
        trial = min(trials, key=lambda fit: fit.left)
        if not _is_significant(best, trial, unexplained_torque, least):
            break
        chosen, best = trial.names, trial
    for name in chosen[:-1]:
        without = tuple(other for other in chosen if other != name)
        trial = _fit(units, without, unexplained_torque, weight)
        if not _is_significant(trial, best, unexplained_torque, least):
            chosen, best = without, trial
    return best


def _with_confounders(fit: Fit, units, unexplained_torque, weight) -> Fit:
    """
    Return the fit with errors as wide as what other causes would change.

    A cause that explains too little to be named may still act, and the causes found have then
    taken its share: where one is significant and changes them, it is a confounder.

    """
    confounders, error = [], fit.error
    for name in units:
        if name in fit.names or not fit.names:
            continue
        trial = _fit(units, (*fit.names, name), unexplained_torque, weight)
        count = len(fit.value)
        moved = np.abs(trial.value[:count] - fit.value)
        significant = np.abs(trial.value[count:]) > SIGNIFICANT * trial.error[count:]
        if significant.any() and (moved > SIGNIFICANT * fit.error).any():
            confounders.append(name)
            error = np.maximum(error, np.hypot(moved, trial.error[:count]))
    return fit._replace(error=error, confounders=tuple(confounders))


def _is_significant(
    without: Fit, with_: Fit, unexplained_torque: np.ndarray, least: float,
) -> bool:
    gain = without.left - with_.left
    more = len(with_.value) - len(without.value)
    noise = with_.left / max(unexplained_torque.size - len(with_.value), 1)
    return gain > least and gain > 1e-3 * without.left and gain > MIN_SIGNAL * more * noise


def _fit(units, names: tuple[str, ...], unexplained_torque, weight) -> Fit:
    y = (unexplained_torque * weight).ravel()
    total = float(y @ y)
    if not names:
        return Fit((), np.zeros(0), np.zeros(0), 1.0)
    x = (np.concatenate([units[name] for name in names], axis=-1)
         * weight[..., None]).reshape(y.size, -1)
    size = np.linalg.norm(x, axis=0)
    size[size == 0.0] = 1.0
    u, s, vt = np.linalg.svd(x / size, full_matrices=False)
    inverse = np.where(s > 1e-10 * s[0], 1.0 / np.maximum(s, 1e-300), 0.0)
    value = vt.T @ (inverse * (u.T @ y))
    left = y - (x / size) @ value
    # Sandwich over blocks: what is left in one block is not independent.
    blocks = (left[:, None] * u).reshape(len(unexplained_torque), 6, -1).sum(axis=1)
    bread = vt.T * inverse
    error = np.sqrt(((bread @ blocks.T)**2).sum(axis=1))
    return Fit(names, value / size, error / size, float(left @ left) / total)


@cache
def _named_arms() -> dict[str, ArmParameters]:
    return {name: load_arm(name) for name in list_arms()}


def _best_arm(samples: SampleBlocks, arm: ArmParameters, weight) -> tuple[str, float]:
    """Return the named arm that leaves least unexplained, and how much."""
    total = float(np.sum((samples.unexplained_torque.mean(axis=1) * weight)**2))
    found = ('', np.inf)
    for name, other in _named_arms().items():
        angles = samples.q - arm.angle_offset + other.angle_offset
        torque = inverse_dynamics(angles, samples.qd, samples.qdd, other)
        left = float(np.sum(((samples.effort - torque).mean(axis=1) * weight)**2)) / total
        if left < found[1]:
            found = (name, left)
    return found


def _arm_cause(name: str, arm: ArmParameters, share: float) -> dict[str, Any]:
    other = _named_arms()[name]
    differs = []
    for what, mine, its, unit in (
            ('mass', arm.mass, other.mass, 'kg'),
            ('rotor inertia', arm.armature, other.armature, 'kg m^2'),
            ('gravity', arm.gravity[2:], other.gravity[2:], 'm/s^2')):
        i = int(np.argmax(np.abs(mine - its)))
        if abs(mine[i] - its[i]) > 1e-12:
            where = f' {i + 1}' if len(mine) > 1 else ''
            differs.append(f'{what}{where} {its[i]:.6g} {unit} instead of {mine[i]:.6g}')
    detail = f': {", ".join(differs)}' if differs else ''
    return {'kind': 'wrong arm', 'arm': name, 'share': share,
            'sentence': f"the plant moves as arm {name}, not as the law's arm {arm.name}"
            f'{detail} (explains {share:.4%} of the squared residual)'}


def _sentences(fit: Fit, arm: ArmParameters) -> list[dict[str, Any]]:
    """Return one cause for each group of the fit, and one for what stays unexplained."""
    causes, start = [], 0
    share = 1.0 - fit.left
    for name in fit.names:
        count = {'payload': 10, 'gravity': 3}.get(name, 6)
        value = fit.value[start:start + count]
        error = np.maximum(fit.error[start:start + count], PRECISION * np.abs(value).max())
        start += count
        make = {'payload': _payload, 'gravity': _gravity}.get(name, _per_joint)
        cause = {'share': share, **make(name, value, error, arm)}
        if fit.confounders:
            cause['rivals'] = list(fit.confounders)
            others = ' and '.join(fit.confounders)
            cause['sentence'] += f'; this motion does not tell it from {others}, hence the error'
        causes.append(cause)
    if fit.left > 0.05:
        causes.append({'kind': 'unexplained', 'share': fit.left,
                       'sentence': f'{fit.left:.1%} of the squared residual is noise or '
                       'fits none of the known causes'})
    return causes


def _payload(name, value, error, arm) -> dict[str, Any]:
    mass, com = value[0], value[1:4] / value[0] if value[0] else np.zeros(3)
    com = np.where(np.abs(com) > PRECISION, com, 0.0)
    place = ', '.join(f'{x:.3g}' for x in com)
    return {'kind': 'payload', 'mass_kg': mass, 'mass_error_kg': error[0], 'com_m': com.tolist(),
            'sentence': f"{mass:.4g} +- {error[0]:.1g} kg at the tool that the law's arm does "
            f'not have, centre of mass at [{place}] m in tool0'}


def _gravity(name, value, error, arm) -> dict[str, Any]:
    found = arm.gravity + value
    size, own = np.linalg.norm(found), np.linalg.norm(arm.gravity)
    ratio = size / own
    kind, words = 'gravity', f'gravity of {size:.5g} m/s^2 instead of {own:.5g}'
    if ratio < 0.02:
        kind, words = 'gravity missing', 'gravity missing: the plant has none'
    elif abs(ratio - 2.0) < 0.02:
        kind, words = 'gravity doubled', 'gravity doubled: the plant has it twice'
    return {'kind': kind, 'gravity': found.tolist(), 'error': error.tolist(),
            'sentence': f'{words} (+- {error.max():.1g} m/s^2)'}


def _per_joint(name, value, error, arm) -> dict[str, Any]:
    sure = np.flatnonzero((np.abs(value) > SIGNIFICANT * error)
                          & (np.abs(value) > 1e-3 * np.abs(value).max()))
    unit = _UNITS[name]
    what = 'rotor inertia (armature)' if name == 'armature' else name
    listed = ', '.join(f'{JOINT_NAMES[i]} {value[i]:.4g} +- {error[i]:.1g}' for i in sure)
    return {'kind': name, 'joints': {JOINT_NAMES[i]: {'value': float(value[i]),
                                                       'error': float(error[i])} for i in sure},
            'sentence': f"{what} that the law's arm does not have [{unit}]: {listed or 'slight'}"}
