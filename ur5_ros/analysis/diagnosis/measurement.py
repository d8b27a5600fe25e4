"""Causes in how a robot measures torque: an offset, a factor or a delay of its efforts."""

import numpy as np

from ur5_ros.analysis.residual_blocks import SampleBlocks

OFFSET, FACTOR, DELAY = 'torque offset', 'torque factor', 'torque delay'

#: Every one of them: they explain an effort, not a motion.
MEASUREMENT = (OFFSET, FACTOR, DELAY)

#: Factors that torque constants can be off by; beyond them the effort is something else.
LEAST, MOST_TIMES = 0.5, 2.0

#: Longest delay that is named [s].
LONGEST = 0.2


def measurement_units(samples: SampleBlocks, torque: np.ndarray,
                      weightless: bool) -> dict[str, np.ndarray]:
    """
    Return what a unit of each adds to the effort, block means: name -> (b, 6, parameters).

    ``torque`` (b, w, 6): what the arm needs; ``weightless``: the effort was recorded without
    gravity, so that a factor of it is none of the torque.
    """
    diagonal = np.eye(6)
    units = {OFFSET: np.broadcast_to(diagonal, (len(torque), 6, 6)),
             FACTOR: torque.mean(axis=1)[:, :, None] * diagonal}
    if weightless:
        del units[FACTOR]
    seconds = samples.time[:, -1] - samples.time[:, 0]
    if torque.shape[1] > 1 and (seconds > 0.0).all():
        rate = (torque[:, -1] - torque[:, 0]) / seconds[:, None]
        units[DELAY] = -rate[:, :, None]
    return units


def is_possible(name: str, value: np.ndarray) -> bool:
    """Return whether a measurement can be so."""
    if name == FACTOR:
        return bool((1.0 + value > LEAST).all() and (1.0 + value < MOST_TIMES).all())
    return name != DELAY or 0.0 < float(value[0]) < LONGEST
