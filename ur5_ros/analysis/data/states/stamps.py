"""Stamps of joint states: which clock is used, its jumps, its jitter, and stamps that stray."""

import numpy as np

from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.wording import agree, number_of

#: Jitter of the stamps that is worth a sentence, as a share of the period.
JITTER = 0.01

#: States beyond a step of the stamps that is this many times the rest are none of the recording,
#: if they are no more than this share.
STRAY, FEW = 10.0, 0.05

#: Share of the stamps that must differ.
DIFFERENT_SHARE = 0.5

#: A clock jumps where its step differs from that of the log by this time [ns] and by this many
#: periods; most jumps, and fewest states between two.
JUMP, JUMP_PERIODS, MOST_JUMPS, SHORTEST = 50_000_000, 10.0, 5, 3


def usable_stamps(columns: Columns, counts: dict[str, int], remarks: list[str]) -> np.ndarray:
    """
    Return the header stamps without jumps of their clock; log times where stamps are useless [ns].

    ``remarks`` receives a sentence about what was done.

    """
    stamp = columns.stamp
    if _are_different(columns, stamp):
        return _without_jumps(columns, remarks)
    if len(np.unique(columns.log_time)) <= DIFFERENT_SHARE * len(stamp):
        return stamp
    which = 'zero' if not stamp.any() else 'repeated for most states'
    remarks.append(f'stamps are {which}; the log time was used')
    counts['log_time_used'] = len(stamp)
    return columns.log_time


def _are_different(columns: Columns, stamp: np.ndarray) -> bool:
    """Return whether most stamps differ, copies of a message counted once."""
    different = len(np.unique(stamp))
    if different > DIFFERENT_SHARE * len(stamp):
        return True
    rows = np.column_stack([stamp, np.ascontiguousarray(columns.position).view(np.int64)])
    return bool(different > DIFFERENT_SHARE * len(np.unique(rows, axis=0)))


def _without_jumps(columns: Columns, remarks: list[str]) -> np.ndarray:
    """Return the stamps as of the clock that most states have, jumps taken out by the log time."""
    order = np.argsort(columns.log_time, kind='stable')
    order = order[columns.stamp[order] > 0]
    if len(order) < 2 * SHORTEST:
        return columns.stamp
    step, logged = np.diff(columns.stamp[order]), np.diff(columns.log_time[order])
    period = float(np.median(logged))
    surplus = step - period
    jumps = 1 + np.flatnonzero(
        (np.abs(surplus) > max(float(JUMP), JUMP_PERIODS * period))
        & (np.abs(logged - period) < 0.1 * np.abs(surplus)))
    edges = np.concatenate([[0], jumps, [len(order)]])
    if not len(jumps) or len(jumps) > MOST_JUMPS or np.diff(edges).min() < SHORTEST:
        return columns.stamp
    ahead = np.concatenate([[0], np.cumsum(step[jumps - 1] - logged[jumps - 1])])
    own = int(np.argmax(np.diff(edges)))
    stamp = columns.stamp.copy()
    for i, (begin, end) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        stamp[order[begin:end]] -= ahead[i] - ahead[own]
    places = (columns.log_time[order[jumps]] - columns.log_time[order[0]]) * 1e-9
    listed = ', '.join(f'by {size * 1e-9:.4g} s at {place:.4g} s' for size, place in
                       zip(np.diff(ahead), places, strict=True))
    remarks.append(f'the clock of the stamps jumps {listed}; the log time shows no such step, so '
                   'it was taken out')
    return stamp


def without_stray_ends(stamp: np.ndarray, rows: np.ndarray, remarks: list[str]) -> np.ndarray:
    """Return the rows without a few at an end whose stamps are far from all others."""
    found = rows
    for _ in range(2):
        steps = np.diff(stamp[found])
        if len(steps) < 3:
            break
        last = int(np.argmax(steps))
        before, after = last + 1, len(found) - last - 1
        few = max(1, int(FEW * len(found)))
        if min(before, after) > few or steps[last] <= STRAY * (steps.sum() - steps[last]):
            break
        found = found[before:] if before < after else found[:before]
    stray = len(rows) - len(found)
    if stray:
        remarks.append(f'{number_of(stray, "state", len(stamp))} {agree(stray, "have")} a stamp '
                       'far from all others: dropped')
    return found


def note_jitter(stamp: np.ndarray, remarks: list[str]) -> None:
    """Add a sentence where the steps between stamps differ from the usual one."""
    steps = np.diff(stamp)
    period = float(np.median(steps))
    jitter = float(np.std(steps[steps < 1.5 * period])) * 1e-9
    if jitter > JITTER * period * 1e-9:
        remarks.append(f'the stamps jitter by {jitter * 1e3:.3g} ms RMS around '
                       f'{period * 1e-6:.4g} ms')


def first_of_each(stamp: np.ndarray, rows: np.ndarray, counts: dict[str, int],
                  remarks: list[str]) -> np.ndarray:
    """Return the rows in order of their stamps, of equal ones the first."""
    back = int((np.diff(stamp[rows]) < 0).sum())
    counts['states_back'] = back
    if back:
        remarks.append(f'{number_of(back, "stamp")} {agree(back, "go")} back; the states '
                       'were sorted')
    unique, first = np.unique(stamp[rows], return_index=True)
    copies = len(rows) - len(unique)
    counts['states_copied'] = copies
    if copies:
        remarks.append(f'{number_of(copies, "state", len(rows))} {agree(copies, "repeat")} a '
                       'stamp; the first of each counts')
    return rows[first]


def stamps_by_log_time(columns: Columns, stamp: np.ndarray) -> np.ndarray:
    """Return the stamps of messages that have none or are broken, from their log times [ns]."""
    stamped = stamp > 0
    delay = np.median((columns.log_time - stamp)[stamped])
    return np.concatenate([columns.broken, columns.log_time[~stamped]]) - np.int64(delay)
