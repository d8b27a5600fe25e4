"""Causes between law and plant: delays, joints swapped, gravity counted twice or not at all."""

from itertools import permutations
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.law_torque import law_torque
from ur5_ros.analysis.laws import laws_of, promised_rows
from ur5_ros.analysis.residual import command_defect
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.signals import JOINT_NAMES

#: Longest delay that is tried [control periods], and rows that are compared.
MAX_DELAY, ROWS = 1000, 3000
#: One row in so many is looked at first.
SCREEN = 10

#: Share of the RMS that a cause of the path may leave unexplained.
MAX_LEFT = 0.02


def path_causes(run: Run) -> list[dict[str, Any]]:
    """Return causes between the law's command and the torque that acts: kind, sentence, size."""
    late = _state_delay(run)
    found = ([late] if late else []) + _command_causes(run)
    if all('delay' in cause['kind'] for cause in found):
        # efforts of late states are late as well, unless the exact ones are recorded
        lag = sum(cause['periods'] for cause in found
                  if run.truth is None or cause['kind'] == 'command delay')
        cause = _gravity_convention(run, lag)
        found += [cause] if cause else []
    return found


def lateness_check(run: Run) -> Check:
    """Return whether the law received the newest states, where the exact ones are recorded."""
    name = 'states on time'
    if run.truth is None:
        return not_applicable(name, 'exact states are not recorded beside the published ones')
    cause = _state_delay(run)
    if cause is None:
        return judge(name, 0, 0, 'periods', 'the states published are the newest ones')
    return judge(name, cause['periods'], 0, 'periods', cause['sentence'])


def _state_delay(run: Run) -> dict[str, Any] | None:
    """Return the delay between the exact states and those published."""
    if run.truth is None:
        return None
    known = np.isfinite(run.truth.q).all(axis=1)
    published, true = run.states.q, np.where(known[:, None], run.truth.q, run.states.q)
    best, left, before = _best_lag(published, true)
    if best == 0 or left > 0.2 * before:
        return None
    return _delay('state delay', best, left, before, run)


def _command_causes(run: Run) -> list[dict[str, Any]]:
    if run.command is None:
        return []
    defect = command_defect(run)
    good = np.isfinite(defect).all(axis=1)
    if not good.any():
        return []
    scale = _rms(run.exact.effort[1:][good])
    before = _rms(defect[good])
    if before <= 1e-9 * max(scale, 1.0):
        return []
    # The commands as they acted, without the gravity that the plant adds: what is left to find
    # is a delay or an order of joints.
    sent = run.command[:-1]
    acted = sent + defect
    order, left = _best_order(acted[good], sent[good])
    lag, left_lag, _ = _best_lag(np.where(good[:, None], acted, np.nan),
                                 np.where(good[:, None], sent, np.nan))
    if lag and left_lag <= min(MAX_LEFT * before, left):
        # With the exact states recorded, theirs is known already; else the first ones are copies.
        states = 0 if run.truth is not None else min(lag, _copies(run))
        return [_delay(kind, periods, left_lag, before, run) for kind, periods in
                (('state delay', states), ('command delay', lag - states)) if periods]
    if order != tuple(range(6)) and left <= MAX_LEFT * before:
        pairs = ', '.join(f'{JOINT_NAMES[i]} got the torque of {JOINT_NAMES[j]}'
                          for i, j in enumerate(order) if i != j)
        return [{'kind': 'joint order', 'order': list(order), 'share': 1.0 - (left / before)**2,
                'sentence': f'joint order swapped in the command: {pairs}'}]
    rows = good.nonzero()[0]
    record = run.sim or run.required_control
    arm = record.arm
    gravity = gravity_torque(run.exact.q[rows] + arm.angle_offset, arm)
    cause = _gravity_cause(defect[rows], gravity)
    return [cause] if cause else []


def _gravity_convention(run: Run, lag: int) -> dict[str, Any] | None:
    """Return gravity missing or doubled, from the law recomputed."""
    if run.control is None or run.reference is None:
        return None
    arm = run.control.arm
    laws = [law for law in laws_of(run) if law.promised]
    known = run.has_reference & promised_rows(laws, len(run.stamp))
    rows = np.flatnonzero(run.steps & known[:-1])
    rows = rows[known[rows - lag] & (rows >= lag)]
    if not len(rows):
        return None
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, ROWS).astype(int))]
    gravity = gravity_torque(run.states.q[rows] + arm.angle_offset, arm)
    return _gravity_cause(run.exact.effort[rows + 1] - law_torque(run, laws, rows - lag), gravity)


def _gravity_cause(surplus: np.ndarray, gravity: np.ndarray) -> dict[str, Any] | None:
    """Return the cause if the surplus torque is gravity, once too much or too little."""
    power = float(np.sum(gravity**2))
    if power == 0.0:
        return None
    times = float(np.sum(surplus * gravity)) / power
    before = _rms(surplus)
    left = _rms(surplus - times * gravity)
    if abs(abs(times) - 1.0) > 0.1 or left > 0.2 * before:
        return None
    error = left / np.sqrt(power)
    kind = 'gravity doubled' if times > 0.0 else 'gravity missing'
    words = ('counted twice: the law sends it and the plant adds it again' if times > 0.0 else
             'counted by neither: the law leaves it to the plant, and the plant does not add it')
    return {'kind': kind, 'times': times, 'error': error, 'share': 1.0 - (left / before)**2,
            'sentence': f'gravity {words} ({times:+.4f} +- {error:.1g} times g(q)); set '
            'effort_convention alike on both sides'}


def _best_lag(late: np.ndarray, early: np.ndarray) -> tuple[int, float, float]:
    """
    Return the lag at which ``late[k + lag]`` is nearest to ``early[k]``, and both RMS.

    Rows of NaN do not count.
    """
    n = len(late)
    longest = min(MAX_DELAY, n // 3)
    pick = np.unique(np.linspace(longest, n - 1, ROWS).astype(int))
    known, early_known = (np.isfinite(each).all(axis=1) for each in (late[pick], early))
    late, early = np.nan_to_num(late[pick]), np.nan_to_num(early)

    def square(lag: int, step: int) -> tuple[float, int]:
        """Return the sum of squares over every step-th row, and how many rows count."""
        at = pick[::step] - lag
        weight = known[::step] & early_known[at]
        gap = late[::step] - early[at]
        return np.einsum('ij,ij->i', gap, gap) @ weight, weight.sum()

    # no mean is less than what some of the rows add to it: few lags need all of them
    least = np.array([square(lag, SCREEN)[0] for lag in range(longest + 1)]) / (6 * len(pick))
    mean = np.full(longest + 1, np.inf)
    for lag in [0, *np.argsort(least, kind='stable')]:
        if least[lag] * (1.0 - 1e-9) > mean.min():
            break
        total, count = square(lag, 1)
        if count:
            mean[lag] = total / (6 * count)
    best = int(np.argmin(mean))
    return best, float(np.sqrt(mean[best])), float(np.sqrt(mean[0]))


def _best_order(acted: np.ndarray, sent: np.ndarray) -> tuple[tuple[int, ...], float]:
    """Return the order in which acted[:, i] is nearest to sent[:, order[i]], and the RMS."""
    cost = np.array([[np.mean((acted[:, i] - sent[:, j])**2) for j in range(6)]
                     for i in range(6)])
    every = list(permutations(range(6)))
    total = [sum(cost[i, j] for i, j in enumerate(order)) for order in every]
    best = int(np.argmin(total))
    return every[best], float(np.sqrt(total[best] / 6.0))


def _copies(run: Run) -> int:
    """Return how many of the first states are copies of the first one, as a delay makes them."""
    q, _, effort = run.states
    same = (q == q[0]).all(axis=1) & (effort == effort[0]).all(axis=1)
    return int(np.argmin(same)) - 1 if not same.all() else 0


def _delay(kind: str, lag: int, left: float, before: float, run: Run) -> dict[str, Any]:
    what = 'the law sees states' if kind == 'state delay' else 'commands act'
    return {'kind': kind, 'periods': lag, 'seconds': lag * run.h,
            'share': 1.0 - (left / before)**2 if before else 1.0,
            'sentence': f'{what} {lag} control periods ({lag * run.h * 1e3:.4g} ms) late'}


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
