"""The order of a log's rows in time: turned logs, rows out of order, several recordings in one."""

from typing import NamedTuple

import numpy as np

#: Fewest rows behind a step back in time that make a recording of their own.
OWN_RECORDING = 3


class TimeOrder(NamedTuple):
    """Which rows make one recording; every array of shape (n,)."""

    order: np.ndarray
    """Places of the rows in order of time, those that do not count left out, shape (m,)."""
    repeated: np.ndarray
    """Rows with the time of the row before."""
    stray: np.ndarray
    """Rows whose time is not between those of their neighbours."""
    others: np.ndarray
    """Rows of another recording in the same file."""
    turned: bool
    """Whether the rows run backwards."""


def time_order(t: np.ndarray) -> TimeOrder:
    """Return which rows make one recording, the longest of the file, from their times (n,)."""
    n = len(t)
    turned = bool(n > 2 and np.mean(np.diff(t) < 0.0) > 0.5)
    rows = np.arange(n)[::-1] if turned else np.arange(n)
    stray = _stray(t[rows])
    recordings, short = _recordings(t[rows], np.flatnonzero(~stray))
    stray[short] = True
    own = max(recordings, key=len, default=np.zeros(0, dtype=int))
    others = np.zeros(n, dtype=bool)
    for each in recordings:
        others[each] = each is not own
    same = np.concatenate([[False], np.diff(t[rows[own]]) == 0.0]) if len(own) else own != own
    repeated = np.zeros(n, dtype=bool)
    repeated[own[same]] = True
    back = np.argsort(rows)
    return TimeOrder(rows[own[~same]], repeated[back], stray[back], others[back], turned)


def _stray(t: np.ndarray) -> np.ndarray:
    """Return which rows are ahead of, or behind, two neighbours that are in order."""
    found = np.zeros(len(t), dtype=bool)
    if len(t) < 3:
        return found
    before, here, after = t[:-2], t[1:-1], t[2:]
    for i in (np.flatnonzero((before < after) & ((here > after) | (here < before))) + 1).tolist():
        found[i] = not found[i - 1]
    return found


def _recordings(t: np.ndarray, rows: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """Return rows by recording, time never decreasing in each, and rows that belong to none."""
    edges = np.flatnonzero(np.diff(t[rows]) < 0.0) + 1
    recordings: list[list[np.ndarray]] = []
    short = [np.zeros(0, dtype=int)]
    for piece in np.split(rows, edges):
        if not len(piece):
            continue
        if recordings and t[piece[-1]] > t[recordings[-1][-1][-1]] > t[piece[0]] and (
                np.sum(t[piece] < t[recordings[-1][-1][-1]]) < OWN_RECORDING):
            late = t[piece] < t[recordings[-1][-1][-1]]
            short.append(piece[late])
            recordings[-1].append(piece[~late])
        elif recordings and len(piece) < OWN_RECORDING:
            short.append(piece)
        else:
            recordings.append([piece])
    return [np.concatenate(each) for each in recordings], np.concatenate(short)
