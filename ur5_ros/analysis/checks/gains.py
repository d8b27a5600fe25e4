"""Kp and Kd read back from the recorded e(t), with standard errors."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.error_dynamics import ErrorDynamics
from ur5_ros.analysis.laws import Law, law_active, laws_of
from ur5_ros.analysis.result import FAIL, PASS, Check, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.signals import JOINT_NAMES

#: Relative standard error above which a recording does not determine a gain.
MAX_RELATIVE_ERROR = 0.2


class RecoveredGains(NamedTuple):
    """Gains of one joint as the recording shows them."""

    kp: float
    kd: float
    kp_error: float
    """Standard error."""
    kd_error: float
    """Standard error."""


def gains_check(run: Run, marks: Marks, dynamics: ErrorDynamics | None) -> Check:
    """Return whether the recorded error follows the gains that the bag states."""
    name = 'gains'
    if dynamics is None:
        return not_applicable(name, 'no reference is recorded' if run.reference is None else
                              'the law is not recorded')
    laws = [law for law in laws_of(run) if law.promised]
    if not laws:
        return not_applicable(name, 'only computed torque promises a linear error equation')
    diagonal = [law for law in laws
                if all(np.array_equal(gain, np.diag(np.diag(gain))) for gain in law.gains)]
    if not diagonal:
        return not_applicable(name, 'the gains couple the joints: the sampled equation judges')
    limit = marks['gains'] * (1.0 if run.substeps == 1 else 1.0 + run.h * 1e3)
    active = law_active(run)
    # where the torque is held, the error must stand out of what that makes of it
    held = np.zeros(6) if run.substeps == 1 else 20.0 * np.nanmax(
        np.abs(dynamics.cost), axis=0, initial=0.0)
    worst, failed = 0.0, []
    details: list[dict[str, Any]] = []
    for law in diagonal:
        counted = active & _rows(law, len(active))
        found = recover_gains(run, dynamics, law, counted)
        size = np.nanmax(np.abs(dynamics.error[law.first:law.end]), axis=0, initial=0.0)
        joints = {}
        for i, (joint, gains) in enumerate(zip(JOINT_NAMES, found, strict=True)):
            if gains is None or size[i] <= held[i]:
                continue
            joints[joint] = gains._asdict()
            away, words = _compare(gains, law, i, limit)
            worst = max(worst, away)
            failed += [f'{joint} {word}' for word in words]
        details.append({'from_s': float(run.t[law.first]), 'joints': joints})
    count = max(len(each['joints']) for each in details)
    if not count:
        return not_applicable(name, 'no joint leaves its reference enough to show its gains')
    live = f', each of the {len(details)} sets in its time' if len(details) > 1 else ''
    sentence = (f'Kp and Kd read back from e(t) on {count} joints differ by at most {worst:.2%} '
                f'from the parameters{live}')
    if failed:
        more = f'; {len(failed) - 1} more' if len(failed) > 1 else ''
        sentence = f'{failed[0]}{more}'
    return Check(name, FAIL if failed else PASS, sentence, worst, limit, '1',
                 {'joints': details[0]['joints']} if len(details) == 1 else {'laws': details})


def _rows(law: Law, count: int) -> np.ndarray:
    rows = np.arange(count)
    return (law.first <= rows) & (rows < law.end)


def _compare(found: RecoveredGains, law: Law, i: int, limit: float) -> tuple[float, list[str]]:
    """Return the relative error of the gains read back, and in words which are too far off."""
    worst, words = 0.0, []
    for symbol, value, error, stated in (
            ('Kp', found.kp, found.kp_error, law.gains.kp[i, i]),
            ('Kd', found.kd, found.kd_error, law.gains.kd[i, i])):
        away = abs(value - stated) / stated
        worst = max(worst, away)
        if away > max(limit, 4.0 * error / stated):
            words.append(f'shows {symbol} {value:.4g} +- {error:.2g}, not {stated:.4g}')
    return worst, words


def recover_gains(
    run: Run, dynamics: ErrorDynamics, law: Law, counted: np.ndarray,
) -> list[RecoveredGains | None]:
    """
    Return the gains of each joint, None where the motion does not determine them.

    Least squares with lagged instruments:

    (d' - d - rate)/h = -Kp e - Kd d, ``rate`` being what sampling and holding cost, is summed
    over blocks of samples, in which encoder noise of the rates cancels but for its ends; the block
    before serves as the instrument, whose noise is independent of the block's own. ``counted``
    are the periods in which the law was active, shape (n - 1,).

    """
    block = max(1, round(0.02 * run.control_rate))
    count = len(counted) // block
    if count < 8:
        return [None] * 6
    rows = slice(0, count * block)
    feedback = (dynamics.error[:-1][rows] @ law.gains.kp.T
                + dynamics.rate[:-1][rows] @ law.gains.kd.T)
    whole = np.all(counted[rows].reshape(count, block), axis=1)
    target = _means(dynamics.step[rows, 6:] / run.h - feedback, block)
    regressor = -np.stack([_means(dynamics.error[:-1][rows], block),
                           _means(dynamics.rate[:-1][rows], block)], axis=-1)
    use = whole[1:] & whole[:-1]
    return [_fit(target[1:, i][use], regressor[1:, i][use], regressor[:-1, i][use])
            for i in range(6)]


def _means(values: np.ndarray, block: int) -> np.ndarray:
    return values.reshape(-1, block, values.shape[1]).mean(axis=1)


def _fit(y: np.ndarray, x: np.ndarray, z: np.ndarray) -> RecoveredGains | None:
    if len(y) < 8:
        return None
    try:
        bread = np.linalg.inv(z.T @ x)
    except np.linalg.LinAlgError:
        return None
    value = bread @ (z.T @ y)
    left = y - x @ value
    error = np.sqrt(np.diag(bread @ (z.T * left**2) @ z @ bread.T))
    if not np.all(np.isfinite(value)) or np.any(error > MAX_RELATIVE_ERROR * np.abs(value)):
        return None
    if np.sqrt(np.mean(x[:, 0]**2)) < 1e-7:
        return None
    return RecoveredGains(*map(float, (*value, *error)))
