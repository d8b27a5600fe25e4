"""Motor current as the effort: its factors to torque, whether drives have them, and in words."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.fit import CLEARLY_BETTER, fit_current, relative_size, torque_of
from ur5_ros.analysis.residual_blocks import sample_blocks
from ur5_ros.model.parameters import ArmParameters

#: A factor between current and torque is at least this [N m/A].
LEAST_FACTOR = 2.0

#: Factors from current to torque that drives of the family can have [N m/A]: at most this much,
#: and in N m/mA.
LARGEST_DRIVE, MOST_OF_MILLI = 50.0, 0.05

#: Spread of the factors under which the effort is torque in another unit.
FACTOR_SPREAD = 0.02

#: The meaning in words.
MOTOR_CURRENT = 'motor current'


def drive_factors(
    run: Run, arm: ArmParameters,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """
    Return the torque of a unit of motor current per joint [N m/A], and effort and its model.

    The latter two are block means [A], shape (b, 6); None where too few states have a current.

    """
    if run.current is None:
        return None
    states = run.states._replace(effort=run.current)
    samples = sample_blocks(replace(run, states=states, truth=None, follows_reference=False), arm)
    if samples is None:
        return None
    effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
    factors, model = fit_current(effort, torque, samples)
    shifted = fit_current(effort, torque, samples, constant=True)
    if relative_size(effort - shifted[1], effort) < CLEARLY_BETTER * relative_size(
            effort - model, effort):
        factors, model = shifted
    return factors, effort, model


def are_factors_of_drives(factors: Sequence[float]) -> bool:
    """Return whether every known factor has the same sign and one that a drive can have."""
    known = np.array(factors)[np.isfinite(factors)]
    if not len(known) or not ((known > 0.0).all() or (known < 0.0).all()):
        return False
    middle = float(np.median(np.abs(known)))
    alike = np.ptp(known) < FACTOR_SPREAD * middle
    return middle > LEAST_FACTOR or middle < MOST_OF_MILLI or bool(alike and middle < 0.5)


def words_of_factors(factors: Sequence[float]) -> tuple[str, str]:
    """Return what an effort with these factors looks like, and the factors in words."""
    known = np.array([each for each in factors if np.isfinite(each)])
    if not len(known):
        return MOTOR_CURRENT, 'no factors'
    middle = float(np.median(known))
    if len(known) > 2 and np.ptp(known) < FACTOR_SPREAD * abs(middle):
        return 'joint torque in another unit', f'{middle:.4g} N m a unit at every joint'
    if abs(middle) > LARGEST_DRIVE or MOST_OF_MILLI < abs(middle) < LEAST_FACTOR:
        return ('joint torque in another unit', 'joints 1 to 6: ' + ', '.join(
            '-' if np.isnan(each) else f'{each:.4g}' for each in factors) + ' N m a unit')
    milli = abs(middle) < MOST_OF_MILLI
    listed = ', '.join('-' if np.isnan(each) else f'{each * (1e3 if milli else 1.0):.4g}'
                       for each in factors)
    looks = MOTOR_CURRENT + (' in mA' if milli else '') + (
        ' with the other sign' if middle < 0.0 else '')
    return looks, f'factors of joints 1 to 6: {listed} N m/A'
