"""Whole turns: the same pose with joints 2 pi further, as far as the limits let them."""

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters, Limits

TURN = 2.0 * np.pi


def limits_of_model(arm: ArmParameters, limits: Limits | None) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the position limits in the angles of the arm record.

    ``limits``: limits in the manufacturer's angles; those of the arm where none are given.
    Returned: ``lower``, ``upper`` (6,): limits plus ``arm.angle_offset`` [rad].
    """
    limits = arm.limits if limits is None else limits
    for name in ('lower', 'upper'):
        value = np.asarray(getattr(limits, name), dtype=float)
        if value.shape != (6,) or np.isnan(value).any():
            raise InputError(f'limits.{name} is {value.tolist()}; give six numbers [rad], '
                             'infinite where nothing limits')
    if np.any(limits.lower > limits.upper):
        joint = int(np.argmax(limits.lower > limits.upper))
        raise InputError(f'limits of joint {joint + 1} are {limits.lower[joint]} to '
                         f'{limits.upper[joint]} rad; the lower must not be above the upper')
    return limits.lower + arm.angle_offset, limits.upper + arm.angle_offset


def turns_allowed(
    q: np.ndarray, lower: np.ndarray, upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the least and the most turns that keep each joint within limits.

    ``q`` (..., 6): joint positions [rad]; ``lower``, ``upper`` (6,): limits in the same angles,
    1e-9 rad taken as rounding.  Returned: ``least``, ``most`` (..., 6): whole numbers, infinite
    without limits; least > most where no turn helps.
    """
    return np.ceil((lower - 1e-9 - q) / TURN), np.floor((upper + 1e-9 - q) / TURN)
