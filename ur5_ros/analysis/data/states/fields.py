"""Which fields of joint states are measured, and in which rows."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import agree, number_of

FIELDS = ('position', 'velocity', 'effort')

#: Share of the rows that must have a field for it to count as measured; of a source among others
#: that do not have it, and of a part of the recording.
MEASURED, INTERLEAVED, PART = 0.5, 0.1, 0.02

#: Values beyond which a field holds no measurement [rad, rad/s, N m or another unit].
LARGEST = {'position': 1e3, 'velocity': 1e2, 'effort': 1e9}

#: Share of the rows up to which such values are glitches; and what no unit makes of a number.
GLITCHES, NO_NUMBER = 0.02, 1e12

#: A value of a field whose unit is not known is a glitch where it is this many times what all but
#: a few of the rows have at most.
SPIKE, NO_UNIT = 100.0, 1e6

#: A joint turns no further than this [rad]; the last one of some arms does.
FURTHEST, MAY_TURN = 13.0, 5

#: Efforts below this are zero in any unit.
NO_TORQUE = 1e-9

#: A joint that moves by more than this has a velocity [rad].
MOVING_ANGLE = 1e-2


class Fields(NamedTuple):
    """What is measured."""

    position: np.ndarray
    """Impossible values are NaN, shape (n, 6)."""
    velocity: np.ndarray | None
    effort: np.ndarray | None
    needed: tuple[np.ndarray, ...]
    """Fields without which a row does not count."""


def measured_fields(columns: Columns, path: Path, remarks: list[str]) -> Fields:
    """
    Return the fields that are measured; ``remarks`` receives a sentence about what is not.

    InputError if there are no positions, or they are none in rad.

    """
    require_positions(columns, path)
    position, velocity, effort = (
        _without_glitches(columns.fields[field], LARGEST[field]) for field in FIELDS)
    impossible = sum(
        (np.isnan(new) & np.isfinite(columns.fields[field])).any(axis=1).astype(int)
        for field, new in zip(FIELDS, (position, velocity, effort), strict=True))
    if np.any(impossible):
        count = int(np.count_nonzero(impossible))
        remarks.append(f'{number_of(count, "state", len(position))} {agree(count, "hold")} a '
                       'value that no arm can have')
    _refuse_degrees(position, path)
    needed = [position]
    has_velocity = _is_measured(velocity, 'velocity', remarks) and not _is_idle(
        position, velocity, remarks)
    if has_velocity:
        needed.append(velocity)
    has_effort = _is_measured(effort, 'effort', remarks)
    if has_effort and np.abs(np.nan_to_num(effort)).max() < NO_TORQUE:
        remarks.append('no torque is recorded: every effort is zero')
        has_effort = False
    elif has_effort:
        needed.append(effort)
    else:
        whole: np.ndarray = np.isfinite(effort).all(axis=1)
        has_effort = bool(whole.mean() > PART)
        some = bool((np.isfinite(effort).mean(axis=0) > MEASURED).any())
        remarks.append(f'torque is recorded in {whole.sum()} of {whole.size} states alone'
                       if has_effort else 'the torque of the whole arm is needed: none is judged'
                       if some else 'no torque is recorded')
    return Fields(position, velocity if has_velocity else None, effort if has_effort else None,
                  tuple(needed))


def _without_glitches(values: np.ndarray, largest: float) -> np.ndarray:
    """Return a field with impossible values as NaN; where they are many, its unit is another."""
    known = np.abs(np.nan_to_num(values))
    far = known > largest
    ordinary = np.quantile(np.where(far, 0.0, known), 1.0 - GLITCHES, axis=0).max(initial=0.0)
    if ordinary > 0.0 and largest > NO_UNIT:
        far |= known > SPIKE * ordinary
    if far.any(axis=1).mean() > GLITCHES:
        far = np.abs(np.nan_to_num(values)) > NO_NUMBER
    return np.where(far, np.nan, values)


def require_positions(columns: Columns, path: Path) -> None:
    """Raise InputError where a joint has no position."""
    for i, joint in enumerate(JOINT_NAMES):
        if np.isnan(columns.position[:, i]).all():
            which = '' if np.isnan(columns.position).all() else f' of {joint}'
            raise InputError(f'{path}: the joint states have no position{which}; it is needed')


def _refuse_degrees(position: np.ndarray, path: Path) -> None:
    """Raise InputError for positions that no joint has in most rows."""
    for i, joint in enumerate(JOINT_NAMES[:MAY_TURN]):
        known = position[np.isfinite(position[:, i]), i]
        typical = float(np.median(np.abs(known))) if len(known) else 0.0
        if typical > FURTHEST:
            raise InputError(
                f'{path}: {joint} is at {typical:.6g} rad in most joint states, further than any '
                f'of the family turns ({FURTHEST:g} rad); if these are degrees, convert the '
                'recording to rad')


def _is_measured(values: np.ndarray, field: str, remarks: list[str]) -> bool:
    """Return whether rows have a field; where one joint alone lacks it, say which."""
    share = np.isfinite(values).mean(axis=0)
    if (share > MEASURED).all() or _interleave(np.isfinite(values).all(axis=1)):
        return True
    missing = [joint for joint, part in zip(JOINT_NAMES, share, strict=True) if part <= MEASURED]
    if len(missing) < 6:
        remarks.append(f'no {field} of {", ".join(missing)} is measured')
    return False


def _interleave(whole: np.ndarray) -> bool:
    """Return whether rows with a field are spread among rows without it."""
    count = int(whole.sum())
    runs = int((np.diff(whole.astype(int)) == 1).sum()) + int(whole[0])
    return count > INTERLEAVED * len(whole) and 3 * runs > min(count, len(whole) - count)


def _is_idle(position: np.ndarray, velocity: np.ndarray, remarks: list[str]) -> bool:
    """Return whether a velocity is zero throughout although its joint moves."""
    idle = (np.nan_to_num(velocity) == 0.0).all(axis=0) & (
        np.ptp(np.nan_to_num(position - np.nanmedian(position, axis=0)), axis=0) > MOVING_ANGLE)
    if not idle.any():
        return False
    named = [joint for joint, bad in zip(JOINT_NAMES, idle, strict=True) if bad]
    which = 'every velocity' if len(named) == 6 else f'the velocity of {", ".join(named)}'
    remarks.append(f'{which} is zero although the positions change')
    return True
