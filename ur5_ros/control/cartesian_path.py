"""Straight lines of the tool with slerp, timed by stamps or by a speed, at rest in corners."""

from collections.abc import Callable

import numpy as np

from ur5_ros.control.profiles import Curve, ToolSamples, quintic_rise
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import rotation_about, rotation_vector

#: A turn by one radian counts as this length of path [m] (assumed: the size of a tool).
TURN_LENGTH = 0.2
#: Tool acceleration of paths that are timed by a speed [m/s^2] (assumed: a gentle start).
TOOL_ACCELERATION = 0.5
#: Directions that differ less are no corner [-].
_CORNER_TOLERANCE = 1e-3

Law = Callable[[np.ndarray], Curve]


class StraightLines:
    """The tool along a chain of poses: times to poses and their analytic derivatives."""

    def __init__(self, poses: np.ndarray, law_of: Callable[[np.ndarray, np.ndarray], Law]):
        move = np.diff(poses[:, :3, 3], axis=0)
        turn = _turns(poses[:, :3, :3])
        angle = np.linalg.norm(turn, axis=1)
        length = np.maximum(np.linalg.norm(move, axis=1), TURN_LENGTH * angle)
        distance = np.concatenate([[0.0], np.cumsum(length)])
        kept = length > 0.0
        per_length = np.concatenate([move[kept], turn[kept]], axis=1) / length[kept, None]
        self._law = law_of(distance, _stops(per_length, kept))
        self._distance, self._length = distance[:-1][kept], distance[-1]
        self._pose = poses[:-1][kept]
        self._direction = per_length
        self._angle = (angle / np.where(kept, length, 1.0))[kept]
        local = np.matmul(np.swapaxes(self._pose[:, :3, :3], 1, 2), turn[kept][..., None])[..., 0]
        self._axis = local / np.where(angle[kept] > 0.0, angle[kept], 1.0)[:, None]
        self._still = poses[:1]

    @property
    def length(self) -> float:
        """Length of path [m], a turn by one radian counted as :data:`TURN_LENGTH`."""
        return float(self._length)

    def __call__(self, t: np.ndarray) -> ToolSamples:
        """Return the tool at n times [s]."""
        if not self._distance.size:
            zero = np.zeros((t.size, 6))
            return ToolSamples(np.repeat(self._still, t.size, axis=0), zero, zero)
        s = self._law(t)
        leg = np.searchsorted(self._distance, s.value, side='right') - 1
        leg = np.clip(leg, 0, self._distance.size - 1)
        along = (s.value - self._distance[leg])[:, None]
        pose = self._pose[leg]
        pose[:, :3, 3] += along * self._direction[leg, :3]
        spin = rotation_about(self._axis[leg], along[:, 0] * self._angle[leg])
        pose[:, :3, :3] = np.matmul(pose[:, :3, :3], spin)
        return ToolSamples(pose, s.rate[:, None] * self._direction[leg],
                           s.acceleration[:, None] * self._direction[leg])


def straight_legs(poses: np.ndarray, times: np.ndarray) -> StraightLines:
    """
    Return straight lines between poses, at rest in each at its time.

    ``poses`` (n, 4, 4): where to pass; ``times`` (n,): when [s], increasing.
    """
    return StraightLines(poses, lambda s, stops: _timed(s, times, np.ones_like(stops)))


def stamped_path(poses: np.ndarray, times: np.ndarray) -> StraightLines:
    """
    Return straight lines that pass each pose at its time, at rest where the direction changes.

    ``poses`` (n, 4, 4): where to pass; ``times`` (n,): when, from zero [s].
    """
    early = np.flatnonzero(np.diff(times) <= 0.0)
    if early.size:
        i = int(early[0])
        raise InputError(f'pose {i + 2} has the time {times[i + 1]:.6f} s, pose {i + 1} '
                         f'{times[i]:.6f} s; give increasing stamps, or none to use tool_speed')
    return StraightLines(poses, lambda s, stops: _timed(s, times, stops))


def speed_path(poses: np.ndarray, speed: float) -> tuple[StraightLines, float]:
    """
    Return straight lines passed at a tool speed, and how long that takes.

    ``poses`` (n, 4, 4): where to pass; ``speed``: tool speed between the corners [m/s]; a turn by
    one radian counts as :data:`TURN_LENGTH`.  Returned: its duration [s].
    """
    durations = []

    def law_of(distance: np.ndarray, stops: np.ndarray) -> Law:
        law, duration = _paced(distance[stops.astype(bool)], speed)
        durations.append(duration)
        return law

    return StraightLines(poses, law_of), durations[0]


def _stops(per_length: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return which poses are corners: the ends, changes of direction, and where it waits."""
    stops = np.ones(kept.size + 1, dtype=bool)
    legs = np.flatnonzero(kept)
    scale = np.array([1.0] * 3 + [TURN_LENGTH] * 3)
    for before, after in zip(range(legs.size - 1), range(1, legs.size), strict=True):
        bend = np.abs((per_length[after] - per_length[before]) * scale).max()
        stops[legs[after]] = bend > _CORNER_TOLERANCE or legs[after] != legs[before] + 1
    return stops


def _timed(distance: np.ndarray, times: np.ndarray, stops: np.ndarray) -> Law:
    """
    Return distance(t) through all points: quintic pieces without acceleration at the poses.

    Where the tool does not stop it passes at the harmonic mean of the neighbouring mean speeds;
    that is at most twice the lesser one, so that it never runs backwards.

    """
    span = np.diff(times)
    mean = np.diff(distance) / span
    speed = np.zeros(distance.size)
    inner = ~stops.astype(bool)[1:-1]
    before, after = mean[:-1][inner], mean[1:][inner]
    speed[1:-1][inner] = 2.0 * before * after / (before + after)

    def law(t: np.ndarray) -> Curve:
        i = np.clip(np.searchsorted(times, t, side='right') - 1, 0, span.size - 1)
        h = span[i]
        x = (t - times[i]) / h
        rise = quintic_rise(x, 1.0)
        lead, trail = _slopes(x)
        step, v0, v1 = distance[i + 1] - distance[i], speed[i] * h, speed[i + 1] * h
        parts = [step * r + v0 * a + v1 * b
                 for r, a, b in zip(rise, lead, trail, strict=True)]
        return Curve(distance[i] + parts[0], parts[1] / h, parts[2] / (h * h))

    return law


def _slopes(x: np.ndarray) -> tuple[Curve, Curve]:
    """Return the quintics with slope 1 at 0, and with slope 1 at 1, all else zero there."""
    x = np.clip(x, 0.0, 1.0)
    lead = Curve(
        x - x**3 * (6.0 - 8.0 * x + 3.0 * x * x),
        1.0 - x * x * (18.0 - 32.0 * x + 15.0 * x * x),
        -x * (36.0 - 96.0 * x + 60.0 * x * x),
    )
    trail = Curve(
        -x**3 * (4.0 - 7.0 * x + 3.0 * x * x),
        -x * x * (12.0 - 28.0 * x + 15.0 * x * x),
        -x * (24.0 - 84.0 * x + 60.0 * x * x),
    )
    return lead, trail


def _paced(stops: np.ndarray, speed: float) -> tuple[Law, float]:
    """Return distance(t) from stop to stop: the speed rises and falls as a quintic."""
    length = np.diff(stops)
    cruise = np.minimum(speed, np.sqrt(length * TOOL_ACCELERATION / 1.875))
    ramp = 1.875 * cruise / TOOL_ACCELERATION  # the steepest slope of the quintic is 1.875
    duration = ramp + length / np.where(cruise > 0.0, cruise, 1.0)
    times = np.concatenate([[0.0], np.cumsum(duration)])

    def law(t: np.ndarray) -> Curve:
        i = np.clip(np.searchsorted(times, t, side='right') - 1, 0, length.size - 1)
        t = np.minimum(t, times[-1]) - times[i]
        up = _ramp(t, ramp[i])
        down = _ramp(t - (duration[i] - ramp[i]), ramp[i])
        return Curve(*(a + cruise[i] * (u - d) for a, u, d in
                       zip((stops[i], 0.0, 0.0), up, down, strict=True)))

    return law, float(times[-1])


def _ramp(t: np.ndarray, length: np.ndarray) -> Curve:
    """Return the distance under a speed that rises from 0 to 1 within ``length``, and goes on."""
    length = np.where(length > 0.0, length, 1.0)
    x = np.clip(t / length, 0.0, 1.0)
    rise = quintic_rise(x, 1.0)
    distance = length * x**4 * (2.5 - 3.0 * x + x * x) + np.maximum(t - length, 0.0)
    return Curve(distance, rise.value, rise.rate / length)


def _turns(rotations: np.ndarray) -> np.ndarray:
    """Return the rotation vectors in base [rad] that carry each rotation to the next."""
    relative = np.matmul(rotations[1:], np.swapaxes(rotations[:-1], 1, 2))
    return rotation_vector(relative)
