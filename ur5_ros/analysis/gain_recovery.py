"""Kp and Kd read back from the recorded e(t), with standard errors."""

from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.error_dynamics import ErrorDynamics
from ur5_ros.analysis.law_promise import gains_of, law_in_charge, sampling_factor
from ur5_ros.analysis.result import FAIL, PASS, Check, not_applicable
from ur5_ros.analysis.series import Run
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES

#: Relative standard error above which a recording says nothing about a gain.
VAGUE = 0.2


class Recovered(NamedTuple):
    """Gains of one joint as the recording shows them."""

    kp: float
    kd: float
    kp_error: float
    """Standard error."""
    kd_error: float
    """Standard error."""


def gains_check(run: Run, marks: Marks, dynamics: ErrorDynamics | None) -> Check:
    """
    Return whether the recorded error obeys the gains that the bag names.

    Parameters
    ----------
    run : Run
        The recording.
    marks : Marks
        Pass marks.
    dynamics : ErrorDynamics or None
        Error and rate of the run; None where no reference is recorded.

    """
    name = 'gains'
    if dynamics is None:
        return not_applicable(name, 'no reference is recorded')
    if run.control.parameters.get('mode', 'computed_torque') != 'computed_torque':
        return not_applicable(name, 'only computed torque promises a linear error equation')
    gains = gains_of(run)
    if any(np.any(matrix != np.diag(np.diag(matrix))) for matrix in gains):
        return not_applicable(name, 'the gains couple the joints: the sampled equation judges')
    found = recover_gains(run, dynamics, law_in_charge(run))
    if run.substeps != 1:  # the error must stand out of what holding the torque makes of it
        held = 20.0 * marks['settled_held_angle'] * sampling_factor(run)
        found = [gains if np.nanmax(np.abs(dynamics.error[:, i])) > held else None
                 for i, gains in enumerate(found)]
    limit = marks['gains'] * (1.0 if run.substeps == 1 else 1.0 + run.h * 1e3)
    worst, details, told, failed = 0.0, {}, 0, []
    for i, joint in enumerate(JOINT_NAMES):
        if found[i] is None:
            continue
        told += 1
        details[joint] = found[i]._asdict()
        for symbol, value, error, asked in (
                ('Kp', found[i].kp, found[i].kp_error, gains.kp[i, i]),
                ('Kd', found[i].kd, found[i].kd_error, gains.kd[i, i])):
            away = abs(value - asked) / asked
            worst = max(worst, away)
            if away > max(limit, 4.0 * error / asked):
                failed.append(f'{joint} shows {symbol} {value:.4g} +- {error:.2g}, not '
                              f'{asked:.4g}')
    if not told:
        return not_applicable(name, 'no joint leaves its reference enough to show its gains')
    sentence = (f'Kp and Kd read back from e(t) on {told} joints differ by at most {worst:.2%} '
                'from the parameters')
    if failed:
        more = f'; {len(failed) - 1} more' if len(failed) > 1 else ''
        sentence = f'{failed[0]}{more}'
    return Check(name, FAIL if failed else PASS, sentence, worst, limit, '1',
                 {'joints': details})


def recover_gains(
    run: Run, dynamics: ErrorDynamics, counted: np.ndarray,
) -> list[Recovered | None]:
    """
    Return the gains of each joint by least squares with lagged instruments.

    (d' - d - jump)/h = -Kp e - Kd d is summed over blocks of samples, in which encoder noise of
    the rates cancels but for its ends; the block before serves as the instrument, whose noise is
    independent of the block's own.

    Parameters
    ----------
    run : Run
        The recording.
    dynamics : ErrorDynamics
        Error and rate of the run.
    counted : numpy.ndarray of bool, shape (n - 1,)
        Periods in which the law was in charge.

    Returns
    -------
    list
        One :class:`Recovered` a joint; None where the motion does not tell.

    """
    block = max(1, round(0.02 * run.control_rate))
    count = len(counted) // block
    if count < 8:
        return [None] * 6
    star, h = run.reference, run.h
    change = np.diff(dynamics.rate, axis=0) - (star.qd[:-1] + h * star.qdd[:-1] - star.qd[1:])
    rows = slice(0, count * block)
    whole = np.all(counted[rows].reshape(count, block), axis=1)
    target = _means(change[rows] / h, block)
    regressor = -np.stack([_means(dynamics.error[:-1][rows], block),
                           _means(dynamics.rate[:-1][rows], block)], axis=-1)
    use = whole[1:] & whole[:-1]
    return [_fit(target[1:, i][use], regressor[1:, i][use], regressor[:-1, i][use])
            for i in range(6)]


def _means(values: np.ndarray, block: int) -> np.ndarray:
    return values.reshape(-1, block, values.shape[1]).mean(axis=1)


def _fit(y: np.ndarray, x: np.ndarray, z: np.ndarray) -> Recovered | None:
    if len(y) < 8:
        return None
    try:
        bread = np.linalg.inv(z.T @ x)
    except np.linalg.LinAlgError:
        return None
    value = bread @ (z.T @ y)
    left = y - x @ value
    error = np.sqrt(np.diag(bread @ (z.T * left**2) @ z @ bread.T))
    if not np.all(np.isfinite(value)) or np.any(error > VAGUE * np.abs(value)):
        return None
    if np.sqrt(np.mean(x[:, 0]**2)) < 1e-7:
        return None
    return Recovered(*map(float, (*value, *error)))
