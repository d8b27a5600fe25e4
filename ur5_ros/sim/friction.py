"""Dry friction, brakes and stops at the new velocity: one convex problem, solved exactly."""

from functools import cache
from types import ModuleType

import numpy as np

#: Rows of the kernel's working space.
WORK = 11


def solve_friction(
    A: np.ndarray, drive: np.ndarray, qd: np.ndarray, level: np.ndarray,
    lower: np.ndarray, upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    r"""
    Return the change of velocity under a drive, against resistance taken at the new velocity.

    Find v' = qd + delta and the resistance f with

    .. math:: A \delta + f = drive, \quad f_i \in level_i \, \mathrm{Sgn}(v'_i) + N(v'_i)

    where Sgn(0) = [-1, 1] and N is the reaction of a stop: zero between ``lower`` and ``upper``,
    of any size outwards at them.  It is the optimality condition of a strictly convex problem
    (minimise v'^T A v' / 2 - (drive + A qd)^T v' + level^T |v'| between the stops), so that there
    is exactly one solution.  Resistance therefore stops a motion but never reverses it, whatever
    the step.  With ``level`` = the torque limits, -f is the brake that minimises v'^T A v'.

    ``A`` (6, 6): inertia by time, and what else is linear in the new velocity [N m s/rad];
    positive definite; ``drive`` (6,): torque that would act at constant velocity [N m]; ``qd``
    (6,): velocity before [rad/s]; ``level`` (6,): largest resistance [N m]; zero = none;
    ``lower``, ``upper`` (6,): velocities at which the stops are reached [rad/s]; infinite = none.
    Returned: ``delta`` (6,): change of velocity [rad/s]; ``f`` (6,): resistance [N m].
    """
    f = drive + A @ qd  # what it takes to stop every joint at once
    if (level > 0.0).any() and (np.abs(f) <= level).all() and (lower <= 0.0).all() and (
            upper >= 0.0).all():
        return -qd, f  # most of what a brake does, without Numba
    delta, f = np.empty(6), np.empty(6)
    # copies: a kernel for arrays that may be written shares its helpers with that of a step
    given = [np.array(each, dtype=float) for each in (A, drive, qd, level, lower, upper)]
    if kernels().friction.run(1, [], [*given, np.empty((WORK, 6))], [delta, f]):
        raise ArithmeticError('the resistance of the joints was not found')
    return delta, f


@cache
def kernels() -> ModuleType:
    """Return the compiled forms; an arm that is plain and kept by its brake starts without."""
    from ur5_ros.sim import integrator_kernel  # loads Numba, which takes longer than all the rest
    return integrator_kernel
