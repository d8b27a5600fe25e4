"""The numbers of a run on the bench."""

import numpy as np

from ur5_ros.loop.loop_run import LoopRun

#: The first part of a run, in which the error of the start dies out, does not count [s].
SETTLING_TIME = 0.5

SCORES = ('rms_error', 'max_error', 'effort', 'energy', 'roughness')


def scores_of(run: LoopRun) -> dict[str, float]:
    """
    Return the scores of a run.

    Returned: ``rms_error`` and ``max_error`` of the exact joint positions after
    :data:`SETTLING_TIME` [rad], ``effort`` (root mean square of the joint torques [N m]),
    ``energy`` (integral of |tau qd| [J]), ``roughness`` (root mean square of the rate of the
    torques [N m/s]).
    """
    exact = run.truth
    q, qd = (run.q, run.qd) if exact is None else (exact.q, exact.qd)
    effort = run.effort if exact is None else exact.effort
    period = 1.0 / run.config.sim.control_rate
    error = (q - run.reference.q)[round(SETTLING_TIME / period):]
    return {
        'rms_error': float(np.sqrt(np.mean(error**2))),
        'max_error': float(np.abs(error).max()),
        'effort': float(np.sqrt(np.mean(effort**2))),
        'energy': float(np.abs(effort * qd).sum() * period),
        'roughness': float(np.sqrt(np.mean(np.diff(effort[1:], axis=0)**2)) / period),
    }
