"""Causes in the plant: another arm, payload, friction, rotor inertia, gravity; fitted."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.diagnosis.differences import differences
from ur5_ros.analysis.diagnosis.friction import (
    FASTEST_DECAY,
    SLOWEST_DECAY,
    stiction_cause,
    stribeck_velocity,
)
from ur5_ros.analysis.diagnosis.selection import (
    SIGNIFICANT,
    Causes,
    Fit,
    choose,
    with_confounders,
)
from ur5_ros.analysis.residual_blocks import (
    SampleBlocks,
    load_torque,
    sample_blocks,
    sliding,
    stribeck_torque,
    unit_torques,
)
from ur5_ros.config import list_arms, load_arm
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor
from ur5_ros.signals import JOINT_NAMES

#: A cause must explain this share of the unexplained torque, squared; more where the plant's time
#: step is not that of the recording, or there is noise.
SHARE_EXACT, SHARE_MEASURED = 1e-6, 1e-3

#: What a true cause leaves at most in exact samples.
ROUNDING = 1e-12

#: Block means below this are rounding [N m].
LEAST_TORQUE = 1e-9

#: Unexplained torque under this share of the largest joint's does not weigh more for being small.
SMALL_EXACT, SMALL_MEASURED = 1e-6, 0.02

#: Smallest standard error, as a share of the value: the model is not known better.
PRECISION = 1e-9

#: How far a real robot's gravity may be from none, the arm's own, or twice that, as a share.
POSSIBLE = 0.02

#: What a mass may be uncertain by before it is not named, as a share of it.
VAGUE = 0.5

_UNITS = {'viscous friction': 'N m s/rad', 'Coulomb friction': 'N m', 'armature': 'kg m^2',
          'load-dependent friction': '1', 'Stribeck friction': 'N m'}
STRIBECK = 'Stribeck friction'


def plant_causes(run: Run, arm: ArmParameters) -> list[dict[str, Any]]:
    """
    Return what in the plant the law's arm does not have, most important first.

    Each has ``kind``, ``sentence``, ``share`` of the squared residual that is explained, and
    sizes with errors.  Another known arm is named before several fitted causes.

    """
    samples = sample_blocks(run, arm)
    if samples is None or not np.abs(samples.unexplained_torque).max() > 0.0:
        return []
    causes = _causes_of(samples, arm)
    least = SHARE_EXACT if samples.exact else SHARE_MEASURED
    other, left = _best_arm(samples, arm, causes.weight)
    fit, causes, velocity = _choose(samples, causes, least)
    if run.sim is None and not _is_gravity_possible(fit, causes):
        causes = causes._replace(units={name: unit for name, unit in causes.units.items()
                                        if name != 'gravity'})
        fit, causes, velocity = _choose(samples, causes, least)
    if not samples.exact:
        fit = with_confounders(fit, causes)
    # one cause alone does as well
    explained = len(fit.names) == 1 and fit.left < min(least, 2.0 * left)
    if other and not explained and (left < least or left < 0.1 and fit.left > ROUNDING and (
            left < 0.5 * fit.left or left < 1.05 * fit.left and len(fit.names) > 2)):
        return [_arm_cause(other, arm, 1.0 - left, samples, causes.weight)]
    found = _sentences(fit, causes)
    for cause in found:
        if cause['kind'] == STRIBECK:
            cause |= {'velocity': velocity, 'sentence': f'{cause["sentence"]}; it has fallen to '
                      f'1/e at {velocity:.4g} rad/s'}
    if samples.exact and (stiction := _stiction(samples, fit, causes)):
        found = [*(cause for cause in found if cause['kind'] != 'unexplained'), stiction]
    return found


def _is_gravity_possible(fit: Fit, causes: Causes) -> bool:
    """Return whether a gravity among the causes is one that a real robot can have or count."""
    if 'gravity' not in fit.names:
        return True
    own = float(np.linalg.norm(causes.arm.gravity))
    times = np.linalg.norm(causes.arm.gravity + fit.value[fit.part('gravity', causes)]) / own
    return bool(min(abs(times - known) for known in (0.0, 1.0, 2.0)) < POSSIBLE)


def _choose(samples: SampleBlocks, causes: Causes, least: float) -> tuple[Fit, Causes, float]:
    """Return the causes chosen, with a Stribeck effect where the others leave something."""
    if not np.abs(causes.torque[causes.weight > 0.0]).max(initial=0.0) > LEAST_TORQUE:
        return Fit((), np.zeros(0), np.zeros(0), 0.0, np.zeros(0, dtype=bool)), causes, 0.0
    first = choose(causes, least)
    if first.left < (ROUNDING if samples.exact else least) or not sliding(samples).any():
        return first, causes, 0.0
    velocity = stribeck_velocity(samples, causes)
    more = causes._replace(
        units={**causes.units, STRIBECK: stribeck_torque(samples, velocity)})
    second = choose(more, least)
    if STRIBECK in second.names and 1.01 * SLOWEST_DECAY < velocity < 0.99 * FASTEST_DECAY:
        return second, more, velocity
    return first, causes, 0.0


def _stiction(samples: SampleBlocks, fit: Fit, causes: Causes) -> dict[str, Any] | None:
    """Return the cause where joints hold more at rest than the fitted friction resists."""
    held, level = samples.unexplained_torque.copy(), np.zeros(samples.qd.shape)
    for name in fit.names:
        value = fit.value[fit.part(name, causes)]
        if name == 'payload':
            held -= dynamics_regressor(
                samples.q, samples.qd, samples.qdd, causes.arm)[..., 50:] @ value
        elif name == 'gravity':
            held -= gravity_torque(samples.q, replace(causes.arm, gravity=value))
        elif name == 'armature':
            held -= value * samples.qdd
        elif name == 'viscous friction':
            held -= value * samples.qd_next
        elif name == 'load-dependent friction':
            level += value * np.abs(load_torque(samples, causes.arm))
        else:
            level += value
    return stiction_cause(samples, held, level)


def _causes_of(samples: SampleBlocks, arm: ArmParameters) -> Causes:
    """Return the unexplained torque and what may explain it; standing still, not friction."""
    units = unit_torques(samples, arm)
    torque = samples.unexplained_torque.mean(axis=1)
    known = sliding(samples)
    if not known.any():  # at rest: the torque of gravity and of a load, as nothing else acts
        known = np.ones_like(known)
        units = {name: units[name] for name in ('payload', 'gravity')}
    scale = np.sqrt(np.mean(torque**2, axis=0))
    # a joint whose torque is small may be all noise, which other joints' columns would then fit
    least = SMALL_EXACT if samples.exact else SMALL_MEASURED
    scale = np.maximum(scale, least * scale.max())
    weight = known / scale / np.sqrt(np.maximum(known.sum(axis=0), 1))
    return Causes(torque, weight, units, arm)


@cache
def _named_arms() -> dict[str, ArmParameters]:
    return {name: load_arm(name) for name in list_arms()}


def _best_arm(samples: SampleBlocks, arm: ArmParameters, weight) -> tuple[str, float]:
    """Return the named arm that leaves least unexplained, same load, and how much."""
    total = float(np.sum((samples.unexplained_torque.mean(axis=1) * weight)**2))
    found = ('', np.inf)
    for name, other in _named_arms().items():
        angles = samples.q - arm.angle_offset + other.angle_offset
        loaded = replace(other, payload=arm.payload)
        torque = inverse_dynamics(angles, samples.qd, samples.qdd, loaded)
        left = float(np.sum(((samples.effort - torque).mean(axis=1) * weight)**2)) / total
        if left < found[1]:
            found = (name, left)
    return found


def _arm_cause(name: str, arm: ArmParameters, share: float, samples: SampleBlocks,
               weight: np.ndarray) -> dict[str, Any]:
    """Return the cause that the plant is another arm, with every parameter that differs."""
    plant = replace(_named_arms()[name], payload=arm.payload)
    mending = differences(arm, plant, samples, (weight > 0.0).astype(float))
    return {
        'kind': 'wrong arm', 'arm': name, 'share': share,
        'differences': [each._asdict() for each in mending.differences],
        'unexplained_rms': mending.before, 'mended_rms': mending.after,
        'sentence': f"the plant moves as arm {name}, not as the law's arm {arm.name}: "
        f'{mending.words()}; the unexplained torque falls from {mending.before:.3g} to '
        f'{mending.after:.2g} N m RMS'}


def _sentences(fit: Fit, causes: Causes) -> list[dict[str, Any]]:
    """Return one cause for each group of the fit, and one for what stays unexplained."""
    found, share = [], 1.0 - fit.left
    for name in fit.names:
        part = fit.part(name, causes)
        value = fit.value[part]
        error = np.maximum(fit.error[part], PRECISION * np.abs(value).max())
        if name == 'payload':
            cause = _payload(value, error, fit.determined[part])
        elif name == 'gravity':
            cause = _gravity(value, error, fit.determined[part], causes.arm)
        else:
            cause = _per_joint(name, value, error)
        cause = {'share': share, **cause}
        if fit.confounders:
            cause['rivals'] = list(fit.confounders)
            others = ' and '.join(fit.confounders)
            cause['sentence'] += f'; this motion does not tell it from {others}, hence the error'
        found.append(cause)
    if fit.left > 0.05:
        still = ('; the arm stands still, and this motion does not tell more: move it to several '
                 'poses' if 'armature' not in causes.units else '')
        found.append({'kind': 'unexplained', 'share': fit.left,
                      'sentence': f'{fit.left:.1%} of the squared residual is noise or '
                      f'fits none of the known causes{still}'})
    return found


def _payload(value, error, determined) -> dict[str, Any]:
    mass = float(value[0])
    if not determined[0] or error[0] > VAGUE * abs(mass):
        return {'kind': 'payload', 'determined': False,
                'sentence': 'a load at the tool explains it, but this motion does not tell its '
                'mass; turn the wrists to several poses'}
    com = value[1:4] / mass
    com = np.where(np.abs(com) > PRECISION, com, 0.0)
    place, unknown = ', '.join(f'{x:.3g}' for x in com), ''
    if not determined[1:4].all():
        place, com = '', np.full(3, np.nan)
        unknown = '; this motion does not tell its centre of mass, turn the wrists'
    where = f', centre of mass at [{place}] m in tool0' if place else unknown
    words = (f"{mass:.4g} +- {error[0]:.1g} kg at the tool that the law's arm does not have"
             if mass > 0.0 else f"{-mass:.4g} +- {error[0]:.1g} kg less at the tool than the "
             "law's arm has")
    return {'kind': 'payload', 'mass_kg': mass, 'mass_error_kg': float(error[0]),
            'com_m': com.tolist(), 'sentence': words + where}


def _gravity(value, error, determined, arm) -> dict[str, Any]:
    found = arm.gravity + value
    size, own = np.linalg.norm(found), np.linalg.norm(arm.gravity)
    if not determined.all():
        return {'kind': 'gravity', 'determined': False,
                'sentence': 'another gravity explains it, but this motion does not tell its '
                'direction; move to several poses'}
    ratio = size / own
    cosine = float(np.clip(found @ arm.gravity / max(size * own, 1e-300), -1.0, 1.0))
    turned = float(np.degrees(np.arccos(cosine)))
    kind, words = 'gravity', f'gravity of {size:.5g} m/s^2 instead of {own:.5g}'
    if ratio < 0.02:
        kind, words = 'gravity missing', 'gravity missing: the plant has none'
    elif turned > max(1.0, SIGNIFICANT * np.degrees(error.max() / size)):
        along = ', '.join(f'{x:.4g}' for x in np.where(np.abs(found) > 1e-6 * size, found, 0.0))
        words = (f'gravity along [{along}] m/s^2 in base, turned by {turned:.4g} deg: '
                 f'{_mounting(turned)}')
    elif abs(ratio - 2.0) < 0.02:
        kind, words = 'gravity doubled', 'gravity doubled: the plant has it twice'
    return {'kind': kind, 'gravity': found.tolist(), 'error': error.tolist(),
            'turned_deg': turned, 'sentence': f'{words} (+- {error.max():.1g} m/s^2)'}


def _mounting(turned: float) -> str:
    """Return in words how an arm is mounted whose gravity is turned by an angle [deg]."""
    if turned > 170.0:
        return 'the arm hangs from a ceiling'
    return 'the arm is mounted on a wall' if 80.0 < turned < 100.0 else 'the arm is tilted'


def _per_joint(name, value, error) -> dict[str, Any]:
    sure = np.flatnonzero((np.abs(value) > SIGNIFICANT * error)
                          & (np.abs(value) > 1e-3 * np.abs(value).max()))
    unit = _UNITS[name]
    what = 'rotor inertia (armature)' if name == 'armature' else name
    listed = ', '.join(f'{JOINT_NAMES[i]} {value[i]:.4g} +- {error[i]:.1g}' for i in sure)
    return {'kind': name, 'joints': {JOINT_NAMES[i]: {'value': float(value[i]),
                                                       'error': float(error[i])} for i in sure},
            'sentence': f"{what} that the law's arm does not have [{unit}]: {listed or 'slight'}"}
