"""What the law promises, and when it was in charge: what the checks of the law share."""

import numpy as np

from ur5_ros.analysis.series import Run
from ur5_ros.control.gains import Gains, gains_from

#: Largest reference acceleration of the profile that the marks were measured on [rad/s^2].
PAPER_ACCELERATION = 0.56


def law_in_charge(run: Run) -> np.ndarray:
    """
    Tell in which periods the law's command acted as it was given, shape (n - 1,).

    Not where a state went unanswered, across a gap, beyond the torque limits, or, when not in
    lockstep, where the command came too late.

    """
    star = np.isfinite(np.hstack([*run.reference])).all(axis=1)
    counted = run.steps & star[:-1] & star[1:]
    if run.command is None:
        return counted
    counted = counted & np.isfinite(run.command[:-1]).all(axis=1)
    if run.sim is None:
        return counted
    effort = run.exact.effort[1:]
    counted &= (np.abs(effort) < run.sim.arm.limits.effort).all(axis=1)
    if not run.sim.parameters['lockstep'] and (
            run.sim.parameters['effort_convention'] == 'total'):
        counted &= (np.abs(effort - run.command[:-1]) <= 1e-9).all(axis=1)
    return counted


def noise_allowance(run: Run) -> float:
    """
    Return by how much encoder noise may move e(t) [rad]; zero without noise.

    The law filters the noise: ten standard deviations of the position and ten of the velocity
    over a second bound what is left of it.

    """
    if run.sim is None:
        return 0.0
    given = run.sim.parameters
    return 10.0 * (given['noise.position'] + given['noise.velocity'] * 1.0)


def sampling_factor(run: Run) -> float:
    """
    Return by how much the marks of the continuous theory grow for this run.

    A reference that is sampled with period h acts on the error equation like Kd h/2 qdd*: the
    marks stand for 1 ms and the paper's profile, and grow with the period and with an
    acceleration beyond :data:`PAPER_ACCELERATION`, with half as much again as another profile
    spreads it over the joints in another way.

    """
    hardest = float(np.nanmax(np.abs(run.reference.qdd), initial=0.0))
    share = hardest / PAPER_ACCELERATION
    return run.h * 1e3 * (1.0 if share <= 1.01 else 1.5 * share)


def gains_of(run: Run) -> Gains:
    """
    Return the gains that the controller's bag names.

    Raises
    ------
    Refusal
        If they make no stable error equation.

    """
    return gains_from(run.control.parameters['kp'], run.control.parameters['kd'])


def largest(values: np.ndarray) -> tuple[float, int, int]:
    """
    Return the largest magnitude, its column and its row; NaN entries are not looked at.

    Parameters
    ----------
    values : numpy.ndarray, shape (n, m)
        Numbers; those that are NaN were not measured.

    """
    size = np.abs(values)
    size[np.isnan(size)] = -1.0
    row, column = np.unravel_index(int(np.argmax(size)), size.shape)
    return float(size[row, column]), int(column), int(row)
