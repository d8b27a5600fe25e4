"""Which recorded joint states count: stamps, copies, missing fields, numbers, other sources."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.continuity import judge_continuity
from ur5_ros.analysis.data.run import States
from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

FIELDS = ('position', 'velocity', 'effort')

#: Jitter of the stamps that is worth a sentence, as a share of the period.
JITTER = 0.01

#: A first or last stamp that is this many times the whole duration away is none of the recording.
STRAY = 10.0

#: Share of the rows that must have a field for it to count as measured.
MEASURED = 0.5


class StateRows(NamedTuple):
    """The joint states that count, in order of their stamps."""

    rows: np.ndarray
    """Rows of the columns, shape (n,)."""
    stamp: np.ndarray
    """[ns], shape (n,), strictly increasing."""
    states: States
    dropped: np.ndarray
    """Stamps of the messages that do not count [ns]."""
    jumps: np.ndarray
    """Rows that begin after a jump of the positions."""


def unique_rows(columns: Columns, counts: dict[str, int], what: str,
                problems: list[str]) -> np.ndarray:
    """Return the rows of the first message of each stamp, in order of the stamps."""
    stamp = columns.stamp
    counts[f'{what}_back'] = int((np.diff(stamp) < 0).sum())
    if len(stamp) and np.all(np.diff(stamp) > 0):
        counts[f'{what}_copied'] = 0
        return np.arange(len(stamp))
    unique, first, inverse = np.unique(stamp, return_index=True, return_inverse=True)
    counts[f'{what}_copied'] = len(stamp) - len(unique)
    differing = 0
    for field in FIELDS:
        a, b = columns.fields[field], columns.fields[field][first][inverse]
        differing = max(differing, int((~((a == b) | np.isnan(a) & np.isnan(b))).any(1).sum()))
    if differing:
        problems.append(f'{differing} {what} repeat a stamp with other numbers; two runs or two '
                        'publishers were mixed')
    return first


def own_rows(columns: Columns, path: Path, counts: dict[str, int],
             problems: list[str]) -> StateRows:
    """Return the states of this package's nodes, up to the first one that is no number."""
    _require_positions(columns, path)
    if np.isnan(columns.velocity).all():
        raise InputError(f'{path}: the joint states have no velocity; it is needed')
    rows = unique_rows(columns, counts, 'states', problems)
    good = np.isfinite(np.hstack([columns.position[rows], columns.velocity[rows]])).all(axis=1)
    effort = columns.effort[rows]
    if not np.isnan(effort).all():
        good &= np.isfinite(effort).all(axis=1)
    if not good.all():
        bad = int(np.argmin(good))
        problems.append(f'{path}: a joint state at {columns.stamp[rows[bad]] * 1e-9:.9g} s holds '
                        'what is no number')
        rows = rows[:bad]
    return StateRows(rows, columns.stamp[rows],
                     States(*(columns.fields[field][rows] for field in FIELDS)),
                     np.zeros(0, np.int64), np.zeros(0, dtype=int))


def foreign_rows(columns: Columns, path: Path, counts: dict[str, int], problems: list[str],
                 remarks: list[str]) -> StateRows:
    """
    Return the states of another recorder that count.

    ``remarks`` receives a sentence about what was dropped or assumed, ``problems`` about what the
    verdict must not pass over.

    """
    _require_positions(columns, path)
    stamp = _usable_stamps(columns, counts, remarks)
    rows = np.flatnonzero(stamp > 0)
    _count(remarks, stamp, ~(stamp > 0), 'have a stamp of zero', placed=False)
    position, velocity, effort = (columns.fields[field] for field in FIELDS)
    has_velocity = _is_measured(velocity, 'velocity', remarks)
    has_effort = _has_effort(effort, remarks)
    fields = [position, *([velocity] if has_velocity else []), *([effort] if has_effort else [])]
    good = np.isfinite(np.hstack(fields)).all(axis=1) & (stamp > 0)
    incomplete = ~good & np.isfinite(position).all(axis=1) & (len(fields) > 1) & np.all(
        [np.isnan(field).all(axis=1) for field in fields[1:]] or [~good], axis=0)
    _count(remarks, stamp, incomplete, 'are of another source that interleaves: they lack a field '
           'that the others have')
    _count(remarks, stamp, ~good & ~incomplete & (stamp > 0), 'hold what is no number')
    rows = rows[good[rows]]
    rows = _first_of_each(stamp, rows, counts, remarks)
    rows = _without_stray_ends(stamp, rows, remarks)
    if len(rows) < 2:
        raise InputError(f'{path}: {len(rows)} states of {len(stamp)} can be used; at least two '
                         f'are needed ({"; ".join(remarks) or "the rest is empty"})')
    t = (stamp[rows] - stamp[rows[0]]) * 1e-9
    found = judge_continuity(t, position[rows], velocity[rows] if has_velocity else None)
    if found.interleaved:
        _count(remarks, stamp, np.isin(np.arange(len(stamp)), rows[~found.keep]),
               'are of another source that interleaves: the velocities cannot explain their '
               'positions')
        rows, t = rows[found.keep], t[found.keep]
    problems += [f'the positions jump at {t[row]:.4g} s by more than the velocities can explain: '
                 'two recordings, or a reset' for row in found.jumps.tolist()[:3]]
    q = np.unwrap(position[rows], axis=0) if len(rows) else position[rows]
    if np.abs(q - position[rows]).max(initial=0.0) > 1.0:
        remarks.append('positions wrap around at a whole turn; they were made continuous')
    qd = velocity[rows] if has_velocity else np.gradient(q, t, axis=0)
    if not has_velocity:
        remarks.append('no velocity is measured; it was differentiated from the positions')
    _note_jitter(stamp[rows], remarks)
    used = np.zeros(len(stamp), dtype=bool)
    used[rows] = True
    effort = effort[rows] if has_effort else np.full(q.shape, np.nan)
    dropped = np.concatenate([stamp[~used & (stamp > 0)],
                              _stamps_by_log_time(columns, stamp)])
    return StateRows(rows, stamp[rows], States(q, qd, effort), np.sort(dropped), found.jumps)


def _stamps_by_log_time(columns: Columns, stamp: np.ndarray) -> np.ndarray:
    """Return the stamps of messages that have none or are broken, from their log times [ns]."""
    stamped = stamp > 0
    delay = np.median((columns.log_time - stamp)[stamped])
    return np.concatenate([columns.broken, columns.log_time[~stamped]]) - np.int64(delay)


def _without_stray_ends(stamp: np.ndarray, rows: np.ndarray, remarks: list[str]) -> np.ndarray:
    """Return the rows without a first or last one whose stamp is far from all others."""
    if len(rows) < 4:
        return rows
    times = stamp[rows]
    begin = int(times[1] - times[0] > STRAY * (times[-1] - times[1]))
    end = len(rows) - int(times[-1] - times[-2] > STRAY * (times[-2] - times[0]))
    count = len(rows) - (end - begin)
    if count:
        remarks.append(f'{count} states of {len(stamp)} have a stamp far from all others: dropped')
    return rows[begin:end]


def _require_positions(columns: Columns, path: Path) -> None:
    for i, joint in enumerate(JOINT_NAMES):
        if np.isnan(columns.position[:, i]).all():
            which = '' if np.isnan(columns.position).all() else f' of {joint}'
            raise InputError(f'{path}: the joint states have no position{which}; it is needed')


def _usable_stamps(columns: Columns, counts: dict[str, int], remarks: list[str]) -> np.ndarray:
    """Return the header stamps, or the log times where the stamps do not say when."""
    stamp = columns.stamp
    if len(np.unique(stamp)) > MEASURED * len(stamp):
        return stamp
    if len(np.unique(columns.log_time)) <= MEASURED * len(stamp):
        return stamp
    which = 'zero' if not stamp.any() else 'repeated for most states'
    remarks.append(f'stamps are {which}; the log time was used')
    counts['log_time_used'] = len(stamp)
    return columns.log_time


def _is_measured(values: np.ndarray, field: str, remarks: list[str]) -> bool:
    """Return whether most rows have a field; where one joint alone lacks it, say which."""
    share = np.isfinite(values).mean(axis=0)
    if (share > MEASURED).all():
        return True
    missing = [joint for joint, part in zip(JOINT_NAMES, share, strict=True) if part <= MEASURED]
    if len(missing) < 6:
        remarks.append(f'no {field} of {", ".join(missing)} is measured')
    return False


def _note_jitter(stamp: np.ndarray, remarks: list[str]) -> None:
    """Add a sentence where the steps between stamps differ from the usual one."""
    steps = np.diff(stamp)
    period = float(np.median(steps))
    jitter = float(np.std(steps[steps < 1.5 * period])) * 1e-9
    if jitter > JITTER * period * 1e-9:
        remarks.append(f'the stamps jitter by {jitter * 1e3:.3g} ms RMS around '
                       f'{period * 1e-6:.4g} ms')


def _has_effort(effort: np.ndarray, remarks: list[str]) -> bool:
    """Return whether torques are recorded: numbers, and not all of them zero."""
    if not _is_measured(effort, 'effort', remarks):
        remarks.append('no torque is recorded')
        return False
    if not np.nan_to_num(effort).any():
        remarks.append('no torque is recorded: every effort is zero')
        return False
    return True


def _first_of_each(stamp: np.ndarray, rows: np.ndarray, counts: dict[str, int],
                   remarks: list[str]) -> np.ndarray:
    """Return the rows in order of their stamps, of equal ones the first."""
    back = int((np.diff(stamp[rows]) < 0).sum())
    counts['states_back'] = back
    if back:
        remarks.append(f'{back} stamps go back; the states were sorted')
    unique, first = np.unique(stamp[rows], return_index=True)
    copies = len(rows) - len(unique)
    counts['states_copied'] = copies
    if copies:
        remarks.append(f'{copies} states of {len(rows)} repeat a stamp; the first of each counts')
    return rows[first]


def _count(remarks: list[str], stamp: np.ndarray, dropped: np.ndarray, why: str,
           placed: bool = True) -> None:
    """Add a sentence about dropped rows, placed in seconds from the first stamp."""
    count = int(dropped.sum())
    if not count:
        return
    place = ''
    if placed:
        start = stamp[stamp > 0].min()
        t = (stamp[dropped] - start) * 1e-9
        place = f', from {t.min():.4g} s to {t.max():.4g} s'
    remarks.append(f'{count} states of {len(stamp)} {why}{place}: dropped')
