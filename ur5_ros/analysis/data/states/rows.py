"""Which recorded joint states count: stamps, copies, missing fields, numbers, other sources."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import States
from ur5_ros.analysis.data.states.continuity import judge_continuity
from ur5_ros.analysis.data.states.fields import (
    FIELDS,
    Fields,
    measured_fields,
    require_positions,
)
from ur5_ros.analysis.data.states.stamps import (
    first_of_each,
    note_jitter,
    stamps_by_log_time,
    usable_stamps,
    without_stray_ends,
)
from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.errors import InputError
from ur5_ros.wording import agree, number_of

#: Speed beside a row of zero velocity at which that row is no measurement [rad/s], and how many
#: rows on either side are looked at.
MOVING, BESIDE = 0.05, 2


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
        problems.append(f'{number_of(differing, what.removesuffix("s"))} '
                        f'{agree(differing, "repeat")} a stamp with other numbers; two runs or '
                        'two publishers were mixed')
    return first


def own_rows(columns: Columns, path: Path, counts: dict[str, int],
             problems: list[str]) -> StateRows:
    """Return the states of this package's nodes, up to the first one that is no number."""
    require_positions(columns, path)
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
                        'a value that is not a number')
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
    fields = measured_fields(columns, path, remarks)
    stamp = usable_stamps(columns, counts, remarks)
    less = ' or less' if (stamp < 0).any() else ''
    _count(remarks, stamp, ~(stamp > 0), f'have a stamp of zero{less}', placed=False)
    rows = np.flatnonzero(_whole(fields, stamp, remarks))
    rows = first_of_each(stamp, rows, counts, remarks)
    rows = without_stray_ends(stamp, rows, remarks)
    if len(rows) < 2:
        raise InputError(f'{path}: {number_of(len(rows), "state", len(stamp))} can be used; at '
                         f'least two are needed ({"; ".join(remarks) or "the rest is empty"})')
    t = (stamp[rows] - stamp[rows[0]]) * 1e-9
    position, velocity = fields.position, fields.velocity
    found = judge_continuity(t, position[rows], None if velocity is None else velocity[rows])
    if found.interleaved:
        _count(remarks, stamp, np.isin(np.arange(len(stamp)), rows[~found.keep]),
               'are of another source that interleaves: the velocities cannot explain their '
               'positions')
        rows = rows[found.keep]
    problems += [
        f'the positions jump at {(stamp[rows[row]] - stamp[rows[0]]) * 1e-9:.4g} s by more than '
        'the velocities can explain: two recordings, or a reset'
        for row in found.jumps.tolist()[:3]]
    keep = _not_filled_in(fields, stamp, rows, remarks)
    jumps = np.searchsorted(np.flatnonzero(keep), found.jumps)
    rows = rows[keep]
    states = _states(fields, stamp[rows], rows, remarks)
    note_jitter(stamp[rows], remarks)
    used = np.zeros(len(stamp), dtype=bool)
    used[rows] = True
    dropped = np.concatenate([stamp[~used & (stamp > 0)], stamps_by_log_time(columns, stamp)])
    return StateRows(rows, stamp[rows], states, np.sort(dropped), jumps)


def _whole(fields: Fields, stamp: np.ndarray, remarks: list[str]) -> np.ndarray:
    """Return which rows have a stamp and every field that is measured."""
    position, *others = fields.needed
    good = np.isfinite(np.hstack(fields.needed)).all(axis=1) & (stamp > 0)
    incomplete = ~good & np.isfinite(position).all(axis=1) & bool(others) & np.all(
        [np.isnan(field).all(axis=1) for field in others] or [~good], axis=0)
    _count(remarks, stamp, incomplete, 'are of another source that interleaves: a field is '
           'missing that the others have')
    _count(remarks, stamp, ~good & ~incomplete & (stamp > 0), 'hold a value that is not a number')
    return good


def _not_filled_in(fields: Fields, stamp: np.ndarray, rows: np.ndarray,
                   remarks: list[str]) -> np.ndarray:
    """Return which rows hold no zeros in place of a measurement, shape (len(rows),)."""
    keep = np.ones(len(rows), dtype=bool)
    if fields.effort is not None:
        zero = (fields.effort[rows] == 0.0).all(axis=1)
        if zero.any() and 2 * zero.sum() < len(rows):
            _count(remarks, stamp, np.isin(np.arange(len(stamp)), rows[zero]),
                   'have an effort of zero in every joint, which is not a measurement')
            keep &= ~zero
    elif fields.velocity is not None:
        speed = np.abs(fields.velocity[rows]).max(axis=1)
        near = np.lib.stride_tricks.sliding_window_view(
            np.pad(speed, BESIDE, 'edge'), 2 * BESIDE + 1)
        before, after = near[:, :BESIDE].max(axis=1), near[:, -BESIDE:].max(axis=1)
        zero = (speed == 0.0) & (np.minimum(before, after) > MOVING)
        if zero.any():
            _count(remarks, stamp, np.isin(np.arange(len(stamp)), rows[zero]),
                   'have a velocity of zero between states that move')
            keep &= ~zero
    return keep


def _states(fields: Fields, stamp: np.ndarray, rows: np.ndarray, remarks: list[str]) -> States:
    """Return positions without wraps, velocities, differentiated if need be, and efforts."""
    q = np.unwrap(fields.position[rows], axis=0)
    if np.abs(q - fields.position[rows]).max(initial=0.0) > 1.0:
        remarks.append('positions wrap around at a whole turn; they were made continuous')
    if fields.velocity is not None:
        qd = fields.velocity[rows]
    else:
        qd = np.gradient(q, (stamp - stamp[0]) * 1e-9, axis=0)
        remarks.append('no velocity is measured; it was differentiated from the positions')
    effort = np.full(q.shape, np.nan) if fields.effort is None else fields.effort[rows]
    return States(q, qd, effort)


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
    remarks.append(f'{number_of(count, "state", len(stamp))} {agree(count, why)}{place}: dropped')
