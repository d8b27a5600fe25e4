"""Limits on the commanded torque; they keep its direction."""

import numpy as np


def limit_torque(
    total: np.ndarray,
    added: np.ndarray,
    effort_limit: np.ndarray,
    before: np.ndarray,
    largest_change: float,
) -> tuple[np.ndarray, str]:
    """
    Return the command within the limits and the names of the limits that acted.

    ``total`` (6,): the command [N m]; ``added`` (6,): what the robot adds to it itself [N m]; the
    effort limit holds for the sum; ``effort_limit`` (6,): largest joint torque [N m]; ``before``
    (6,): the command before [N m]; ``largest_change``: largest change of a joint torque since then
    [N m]; infinite for the first command.  Returned: ``total`` itself where no limit acts, (6,).
    """
    acted = []
    if not (np.abs(total + added) <= effort_limit).all():
        total = effort_scale(total, added, effort_limit) * total
        acted.append('effort')
    change = total - before
    biggest = float(np.abs(change).max())
    if biggest > largest_change:
        total = before + largest_change / biggest * change
        acted.append('rate')
    return total, ', '.join(acted)


def effort_scale(total: np.ndarray, added: np.ndarray, limit: np.ndarray) -> float:
    """
    Return the largest factor up to 1 that keeps every joint torque within its limit.

    One factor for all joints: the direction of the torque, and so of the motion, is kept.

    ``total`` (6,): the command [N m]; ``added`` (6,): what the robot adds to it itself [N m];
    ``limit`` (6,): largest joint torque [N m].
    """
    room = limit - np.sign(total) * added
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        factor = np.where(total != 0.0, room / np.abs(total), np.inf)
    return float(min(1.0, max(0.0, factor.min())))
