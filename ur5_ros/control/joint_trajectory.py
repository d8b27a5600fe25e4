"""Joint trajectories by the rules of ros2_control's joint_trajectory_controller."""

from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.control.quintic import powers, quintic
from ur5_ros.control.tolerances import GoalError, ResultCode
from ur5_ros.control.tool_motion import check_limits
from ur5_ros.control.trajectory import SECOND
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference

#: How far the trajectory may lie from the reference where it takes over [rad]: what lies between
#: is bridged smoothly, more would be a jump.
TAKEOVER_TOLERANCE = 0.1
#: The bridge lasts at most this long [s].
_LONGEST_BRIDGE = 1.0
_SAMPLES_PER_SEGMENT = 16
#: More than any position, speed or acceleration of a joint.
_LARGEST_VALUE = 1e6


class TrajectoryPoint(NamedTuple):
    """One point as in trajectory_msgs/JointTrajectoryPoint."""

    time_from_start: int
    """[ns]."""
    positions: Sequence[float]
    """[rad], in the order of the names."""
    velocities: Sequence[float] = ()
    """[rad/s], or empty."""
    accelerations: Sequence[float] = ()
    """[rad/s^2], or empty."""
    effort: Sequence[float] = ()
    """Must be empty: the law makes the efforts."""


class JointSpline:
    """Segments between points: linear, cubic or quintic, as the fields of their ends allow."""

    def __init__(self, knots: list[int], coefficients: np.ndarray, end: Reference):
        self.duration = knots[-1]
        self._knots, self.coefficients, self._end = knots, coefficients, end
        self.bridge: tuple[float, np.ndarray] | None = None

    def at(self, time: int) -> Reference:
        """Return the reference; the last point from ``duration`` on."""
        if time >= self.duration:
            return self._end
        i = bisect_right(self._knots, time) - 1
        q, qd, qdd = powers((time - self._knots[i]) / SECOND) @ self.coefficients[i]
        if self.bridge is not None and time < self.bridge[0] * SECOND:
            dq, dqd, dqdd = powers(time / SECOND) @ self.bridge[1]
            return Reference(q + dq, qd + dqd, qdd + dqdd)
        return Reference(q, qd, qdd)

    def bridged(self, start: Reference) -> 'JointSpline':
        """Return the spline with what parts it from ``start`` at time 0 faded out smoothly."""
        own, zero = self.at(0), np.zeros(6)
        gap = Reference(start.q - own.q, start.qd - own.qd, zero)
        if max(np.abs(gap.q).max(), np.abs(gap.qd).max()) < 1e-9:
            return self
        bridge = JointSpline(self._knots, self.coefficients, self._end)
        length = min(_LONGEST_BRIDGE, self._knots[1] / SECOND)
        bridge.bridge = (length, quintic(gap, Reference(zero, zero, zero), length))
        return bridge


def joint_spline(
    points: Sequence[TrajectoryPoint],
    order: Sequence[int],
    start: Reference,
    delay: int,
    arm: ArmParameters,
) -> JointSpline:
    """
    Return the motion through checked points, taking over from a reference.

    Before the first point a segment leads there from ``start``; a first point that is due now, or
    past, must lie within :data:`TAKEOVER_TOLERANCE`, and the rest is faded out, so that position
    and velocity of the reference never jump.

    ``order``: ``order[j]`` is the place of joint j in the points; ``delay``: time from now to the
    trajectory's start, negative where it began in the past [ns].  Returned: the motion, time 0 =
    now.
    """
    times = [delay + point.time_from_start for point in points]
    states = [_state(point, order) for point in points]
    if times[0] > 0:
        times.insert(0, 0)
        states.insert(0, (start.q, start.qd, start.qdd))
    if len(times) == 1 or times[-1] <= 0:
        raise InputError('the last point is due at once; give it a time_from_start greater than '
                         'zero')
    coefficients = np.array([
        _segment(states[i], states[i + 1], (times[i + 1] - times[i]) / SECOND)
        for i in range(len(times) - 1)])
    q, qd, _ = states[-1]
    zero = np.zeros(6)
    end = Reference(q, zero if qd is None else qd, zero)
    coefficients, times = _from_now(coefficients, times)
    spline = JointSpline(times, coefficients, end)
    gap = start.q - spline.at(0).q
    if np.abs(gap).max() > TAKEOVER_TOLERANCE:
        joint = int(np.abs(gap).argmax())
        raise InputError(f'joint {joint + 1} would jump by {abs(gap[joint]):.4f} rad; at most '
                         f'{TAKEOVER_TOLERANCE:g} is bridged: give the first point a time to get '
                         'there')
    spline = spline.bridged(start)
    _check_between(spline, times, arm)
    return spline


def check_points(
    points: Sequence[TrajectoryPoint],
    joints: int,
    start: int,
    now: int,
    allow_nonzero_end_velocity: bool,
) -> None:
    """
    Refuse what the joint_trajectory_controller refuses.

    ``start``: stamp of its header [ns]; 0 = at once; ``now``: stamp of the newest state [ns].
    """
    if not points:
        raise InputError('the trajectory has no points; use ~/hold to stop')
    for i, point in enumerate(points):
        _check_arrays(point, i + 1, joints)
        if point.time_from_start < 0:
            raise InputError(f'point {i + 1} has time_from_start '
                             f'{point.time_from_start / SECOND} s; give zero or more')
        if i and point.time_from_start <= points[i - 1].time_from_start:
            raise InputError(f'point {i + 1} has time_from_start '
                             f'{point.time_from_start / SECOND} s, '
                             f'point {i} {points[i - 1].time_from_start / SECOND} s; times must '
                             'strictly increase')
    last = points[-1]
    fastest = max((abs(value) for value in last.velocities), default=0.0)
    if fastest > np.finfo(np.float32).eps and not allow_nonzero_end_velocity:
        raise InputError(f'the last point has a velocity of {fastest:g} rad/s; give zeros, or set '
                         'allow_nonzero_velocity_at_trajectory_end')
    if start and start + last.time_from_start < now:
        late = (now - start - last.time_from_start) / SECOND
        raise GoalError(ResultCode.OLD_HEADER_TIMESTAMP, f'the trajectory ended {late:.3f} s ago; '
                        'give a later stamp, or stamp 0 to start at once')


def _check_arrays(point: TrajectoryPoint, number: int, joints: int) -> None:
    if len(point.effort):
        raise InputError(f'point {number} gives efforts; leave them empty, the law makes them')
    for name in ('positions', 'velocities', 'accelerations'):
        values = getattr(point, name)
        if len(values) != joints and (len(values) or name == 'positions'):
            raise InputError(f'point {number} has {len(values)} {name} for {joints} joints; '
                             f'give {joints}')
        if not np.all(np.abs(np.array(values, dtype=float)) < _LARGEST_VALUE):  # False for NaN
            raise InputError(f'point {number} has {name} {list(values)}; give finite numbers of a '
                             'joint')


def _state(point: TrajectoryPoint, order: Sequence[int]) -> tuple:
    return tuple(np.array(values, dtype=float)[list(order)] if len(values) else None
                 for values in (point.positions, point.velocities, point.accelerations))


def _segment(start: tuple, end: tuple, length: float) -> np.ndarray:
    """Return the coefficients (6 powers, 6 joints) of the segment that both ends allow."""
    q0, v0, a0 = start
    q1, v1, a1 = end
    rows = np.zeros((6, 6))
    if v0 is None or v1 is None:
        rows[0], rows[1] = q0, (q1 - q0) / length
    elif a0 is None or a1 is None:
        rows[0], rows[1] = q0, v0
        rows[2] = (3.0 * (q1 - q0) / length - 2.0 * v0 - v1) / length
        rows[3] = (-2.0 * (q1 - q0) / length + v0 + v1) / length**2
    else:
        return quintic(Reference(q0, v0, a0), Reference(q1, v1, a1), length)
    return rows


def _from_now(coefficients: np.ndarray, times: list[int]) -> tuple[np.ndarray, list[int]]:
    """Return the segments not yet past, the first one re-expanded about now."""
    first = bisect_right(times, 0) - 1
    kept = coefficients[first:].copy()
    late = -times[first] / SECOND
    if late > 0.0:
        for power in range(5):  # Taylor shift by Horner's scheme
            for row in range(4, power - 1, -1):
                kept[0, row] += late * kept[0, row + 1]
    return kept, [0, *times[first + 1:]]


def _check_between(spline: JointSpline, times: list[int], arm: ArmParameters) -> None:
    knots = np.array(times) / SECOND
    t = np.diff(knots)[:, None] * np.linspace(0.0, 1.0, _SAMPLES_PER_SEGMENT)  # (n, samples)
    power = t[..., None] ** np.arange(6)
    rate = np.arange(1, 6) * power[..., :5]
    q = np.matmul(power, spline.coefficients)
    qd = np.matmul(rate, spline.coefficients[:, 1:])
    table = Reference(q.reshape(-1, 6), qd.reshape(-1, 6), np.zeros((q.size // 6, 6)))
    check_limits(table, (knots[:-1, None] + t).ravel(), arm)
    if spline.bridge is not None:
        t = np.linspace(0.0, min(spline.bridge[0], knots[-1]), _SAMPLES_PER_SEGMENT)
        states = [spline.at(round(time * SECOND)) for time in t]
        check_limits(Reference(*(np.array(part) for part in zip(*states, strict=True))), t, arm)
