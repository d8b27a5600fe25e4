"""Continuity of joint positions: rows of a second source, and jumps that no velocity explains."""

from typing import NamedTuple

import numpy as np

#: Position step that needs no velocity [rad], factor on the measured speed, and acceleration
#: that a gap may hide [rad/s^2].
STEP, SPEED_FACTOR, ACCELERATION = 0.01, 2.0, 10.0

#: Speed assumed where none is measured [rad/s].
ASSUMED_SPEED = 7.0

#: Sources that are distinguished, and share of the rows below which one at an end is an accident.
MAX_SOURCES, SMALL_SHARE = 32, 0.01


class Continuity(NamedTuple):
    """Which rows belong together."""

    keep: np.ndarray
    """Rows of the main source, bool, shape (n,)."""
    interleaved: int
    """Number of other sources among them."""
    jumps: np.ndarray
    """First rows after a jump that stays, indices into the rows that are kept."""


def judge_continuity(t: np.ndarray, q: np.ndarray, qd: np.ndarray | None) -> Continuity:
    """
    Return the rows of the main source of positions.

    Rows are linked where the position step is what the velocities allow, whole turns aside. Each
    piece continues the source whose last row allows it; a source inside the main one's time is
    another publisher.

    ``t`` (n,): time [s], increasing; ``q`` (n, 6): positions [rad]; ``qd`` (n, 6): velocities
    [rad/s]; None where they are not measured.
    """
    speed = np.full(len(q), ASSUMED_SPEED) if qd is None else np.abs(qd).max(axis=1)
    linked = _allowed(t[:-1], t[1:], q[:-1], q[1:], speed[:-1], speed[1:])
    if linked.all():
        return Continuity(np.ones(len(q), dtype=bool), 0, np.zeros(0, dtype=int))
    begins = np.concatenate([[0], np.flatnonzero(~linked) + 1])
    ends = np.concatenate([begins[1:], [len(q)]])
    sources: list[list[int]] = []
    for piece, begin in enumerate(begins.tolist()):
        for source in sorted(sources, key=lambda each: -each[-1]):
            last = int(ends[source[-1]]) - 1
            if _allowed(t[last], t[begin], q[last], q[begin], speed[last], speed[begin]).all():
                source.append(piece)
                break
        else:
            if len(sources) < MAX_SOURCES:
                sources.append([piece])
            else:
                sources[-1].append(piece)
    return _main_source(sources, begins, ends, len(q))


def _allowed(t0, t1, q0, q1, speed0, speed1) -> np.ndarray:
    """Return whether position steps are within what speed and acceleration allow, per row."""
    step, dt = np.abs(q1 - q0), t1 - t0
    step = np.minimum(step, np.abs(step - 2.0 * np.pi))
    speed = np.maximum(speed0, speed1)
    limit = STEP + SPEED_FACTOR * speed * dt + 0.5 * ACCELERATION * dt**2
    return np.atleast_1d(step.max(axis=-1) <= limit)


def _main_source(sources: list[list[int]], begins, ends, count: int) -> Continuity:
    """Keep the longest source, and those before and after it that are long as well."""
    size = [sum(int(ends[piece] - begins[piece]) for piece in source) for source in sources]
    main = int(np.argmax(size))
    first, last = sources[main][0], sources[main][-1]
    keep, jumps, interleaved = np.zeros(count, dtype=bool), [], 0
    for i, source in enumerate(sources):
        apart = source[-1] < first or source[0] > last
        if i != main and not (apart and size[i] > max(1.0, SMALL_SHARE * size[main])):
            interleaved += 1
            continue
        for piece in source:
            keep[begins[piece]:ends[piece]] = True
        if i != main:
            jumps.append(int(begins[source[0] if source[0] > last else first]))
    place = np.cumsum(keep) - 1
    return Continuity(keep, interleaved, place[sorted(set(jumps))] if jumps
                      else np.zeros(0, dtype=int))
