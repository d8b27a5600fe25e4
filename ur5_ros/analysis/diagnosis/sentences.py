"""Causes in the plant as values and in words."""

from typing import Any

import numpy as np

from ur5_ros.analysis.diagnosis.link_body import link_cause, masses_instead_of
from ur5_ros.analysis.diagnosis.measurement import DELAY, FACTOR, MEASUREMENT, OFFSET
from ur5_ros.analysis.diagnosis.selection import LINKS, SIGNIFICANT, Causes, Fit
from ur5_ros.signals import JOINT_NAMES

#: Smallest standard error, as a share of the value: the model is not known better.
PRECISION = 1e-9

#: What a mass may be uncertain by before it is not named, as a share of it.
VAGUE_SHARE = 0.5

#: What a centre of mass may be uncertain by before it is not named [m].
VAGUE_CENTRE = 0.05

#: A factor of efforts that differs from one by less is none; factors that differ by less are one.
NEAR_ONE, ALIKE = 1e-3, 0.01

#: Confounders from which on a cause of no certain size is not named.
MANY = 3

_UNITS = {'viscous friction': 'N m s/rad', 'Coulomb friction': 'N m', 'armature': 'kg m^2',
          'load-dependent friction': '1', 'Stribeck friction': 'N m'}


def sentences_of(fit: Fit, causes: Causes) -> list[dict[str, Any]]:
    """Return one cause for each group of the fit, and one for what stays unexplained."""
    found, share = [], 1.0 - fit.left
    for name in fit.names:
        part = fit.part(name, causes)
        value = fit.value[part]
        error = np.maximum(fit.error[part], PRECISION * np.abs(value).max())
        if name == 'payload':
            cause = _payload(value, error, fit.determined[part])
            cause['sentence'] += masses_instead_of(name, fit, causes)
        elif name == 'gravity':
            if np.linalg.norm(value) < SIGNIFICANT * error.max():
                found.append(_undetermined(name, share, fit))
                continue
            cause = _gravity(value, error, fit.determined[part], causes.arm)
        elif name in LINKS:
            cause = link_cause(name, fit, causes)
        elif name in MEASUREMENT:
            cause = _measurement(name, value, error)
        else:
            cause = _per_joint(name, value, error)
        if cause.get('determined') is False and len(fit.confounders) >= MANY:
            found.append(_undetermined(name, share, fit))
            continue
        cause = {'share': share, **cause}
        if fit.confounders:
            cause['rivals'] = list(fit.confounders)
            others = ' and '.join(fit.confounders)
            cause['sentence'] += (f'; this motion does not distinguish it from {others}, '
                                  'hence the error')
        found.append(cause)
    if fit.left > 0.05:
        found.append(unexplained(fit.left, 'armature' not in causes.units))
    return found


def _undetermined(name: str, share: float, fit: Fit) -> dict[str, Any]:
    """Return what stands in place of a cause whose size is within its error."""
    alike = ' and '.join((name, *fit.confounders))
    return {'kind': 'unexplained', 'share': share, 'candidates': [name, *fit.confounders],
            'sentence': f'this motion does not tell {alike} apart, which would explain '
            f'{share:.1%} of the squared residual; move every joint far, and fast'}


def unexplained(left: float, still: bool) -> dict[str, Any]:
    """Return the sentence about what no cause explains."""
    more = ('; the arm stands still, and this motion does not show more: move it to several poses'
            if still else '')
    return {'kind': 'unexplained', 'share': left,
            'sentence': f'{left:.1%} of the squared residual is noise or fits none of the known '
            f'causes{more}'}


def _payload(value, error, determined) -> dict[str, Any]:
    mass = float(value[0])
    if not determined[0] or error[0] > VAGUE_SHARE * abs(mass):
        return {'kind': 'payload', 'determined': False,
                'sentence': 'a load at the tool explains it, but this motion does not determine '
                'its mass; turn the wrists to several poses'}
    com = value[1:4] / mass
    com_error = np.hypot(error[1:4], com * error[0]) / abs(mass)
    com = np.where(np.abs(com) > PRECISION, com, 0.0)
    place, unknown = ', '.join(f'{x:.3g}' for x in com), ''
    if not determined[1:4].all() or com_error.max() > VAGUE_CENTRE:
        place, com = '', np.full(3, np.nan)
        unknown = '; this motion does not determine its centre of mass, turn the wrists'
    where = f', centre of mass at [{place}] m in tool0' if place else unknown
    words = (f"{mass:.4g} +- {error[0]:.1g} kg at the tool that the controller's arm does not have"
             if mass > 0.0 else f"{-mass:.4g} +- {error[0]:.1g} kg less at the tool than the "
             "controller's arm has")
    return {'kind': 'payload', 'mass_kg': mass, 'mass_error_kg': float(error[0]),
            'com_m': com.tolist(), 'com_error_m': com_error.tolist(), 'sentence': words + where}


def _gravity(value, error, determined, arm) -> dict[str, Any]:
    found = arm.gravity + value
    size, own = np.linalg.norm(found), np.linalg.norm(arm.gravity)
    if not determined.all():
        return {'kind': 'gravity', 'determined': False,
                'sentence': 'another gravity explains it, but this motion does not determine its '
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
    if not listed:
        return {'kind': name, 'joints': {}, 'determined': False,
                'sentence': f'{what} explains it, but this motion does not determine how much; '
                'move every joint fast, and back'}
    return {'kind': name, 'joints': {JOINT_NAMES[i]: {'value': float(value[i]),
                                                       'error': float(error[i])} for i in sure},
            'sentence': f"{what} that the controller's arm does not have [{unit}]: {listed}"}


def _measurement(name: str, value: np.ndarray, error: np.ndarray) -> dict[str, Any]:
    """Return a cause in words, with its size by joint."""
    if name == DELAY:
        return {'kind': name, 'delay_s': float(value[0]), 'error_s': float(error[0]),
                'sentence': f'the efforts are {value[0] * 1e3:.3g} +- {error[0] * 1e3:.1g} ms '
                'late beside the motion: a filter, or stamps of another clock'}
    least = NEAR_ONE if name == FACTOR else 1e-3 * np.abs(value).max()
    sure = np.flatnonzero((np.abs(value) > SIGNIFICANT * error) & (np.abs(value) > least))
    shown = 1.0 + value if name == FACTOR else value
    joints = {JOINT_NAMES[i]: {'value': float(shown[i]), 'error': float(error[i])} for i in sure}
    listed = ', '.join(f'{JOINT_NAMES[i]} {shown[i]:.4g} +- {error[i]:.1g}' for i in sure)
    found = {'kind': name, 'joints': joints}
    if not listed:
        return {**found, 'determined': False, 'sentence': f'a {name} explains it, but this motion '
                'does not determine how much; move every joint far'}
    if name == OFFSET:
        return {**found, 'sentence': f'the efforts have a constant offset [N m]: {listed}; take '
                'it off, or set the torque sensors to zero, before recording'}
    every = len(sure) == 6 and np.ptp(shown) < ALIKE
    words = f'{shown.mean():.4g} at every joint' if every else listed
    return {**found, 'sentence': f'the efforts are not 1 times the torque of the arm but {words}: '
            'torque constants that are off; with --effort current any factor a joint is taken'}
