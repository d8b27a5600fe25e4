"""An effort that fits no meaning as it is: with a load, of other joints, or no measurement."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort.current import are_factors_of_drives
from ur5_ros.analysis.effort.fit import CLEARLY_BETTER, SMALL_SHARE, misfit_of, torque_of
from ur5_ros.analysis.effort.load import meanings_with_load
from ur5_ros.analysis.effort.meanings import CONSTANT, VARYING, Hypothesis
from ur5_ros.analysis.residual_blocks import SampleBlocks, sample_blocks
from ur5_ros.model.parameters import ArmParameters

#: Heaviest load that is looked for [kg]: three times what the strongest of the family carries.
HEAVIEST_LOAD = 100.0

#: An effort that varies by less than this share of the torque, and correlates less, is noise.
NOISE, ALIKE = 0.1, 0.5


def unlikely_meaning(run: Run, arm: ArmParameters, limit: float) -> Hypothesis | None:
    """
    Return what an effort is that fits no meaning as it is; None where nothing better is found.

    The meanings with an unknown load at the tool, then joints that are exchanged, then joints
    whose effort stays the same while they move.

    """
    samples = sample_blocks(replace(run, follows_reference=False), arm)
    if samples is None or not np.abs(samples.qd).max() > 0.0:
        return None
    found = meanings_with_load(samples, arm)
    best = min(found, key=lambda each: each.misfit)
    likely = 0.0 < best.load <= HEAVIEST_LOAD and (
        best.meaning != 'current' or are_factors_of_drives(best.factors))
    if likely and best.misfit <= min(0.5 * limit, 0.5 * CLEARLY_BETTER * found[0].misfit):
        return best
    exchanged = min(_exchanged(samples, arm), key=lambda each: each.misfit)
    if exchanged.misfit <= min(0.5 * limit, 0.5 * CLEARLY_BETTER * found[0].misfit):
        return exchanged
    effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
    if _shows_nothing(effort, torque):
        return Hypothesis('constant', 0.0)
    still = _constant_joints(effort, torque)
    return Hypothesis('constant', 0.0, joints=tuple(still.tolist())) if len(still) else None


def _exchanged(samples: SampleBlocks, arm: ArmParameters) -> list[Hypothesis]:
    """Return joint torque with two joints exchanged, or all in the other order."""
    effort, torque = samples.effort.mean(axis=1), torque_of(samples, arm)
    found = []
    for pair in (*combinations(range(6), 2), ()):
        order = np.arange(6)[::-1] if not pair else np.arange(6)
        if pair:
            order[list(pair)] = pair[::-1]
        joints = tuple(pair) or tuple(range(6))
        moved = samples._replace(**{name: getattr(samples, name)[..., order] for name in (
            'q', 'qd', 'qdd', 'qd_next')})
        found += [
            Hypothesis('exchanged', misfit_of(effort[:, order], torque, samples), joints=joints),
            Hypothesis('exchanged', misfit_of(effort[:, order], torque_of(moved, arm), moved),
                       joints=joints, whole=True)]
    return found


def _shows_nothing(effort: np.ndarray, torque: np.ndarray) -> bool:
    """Return whether an effort varies little beside the torque, and not with it."""
    spread, size = np.std(effort, axis=0), np.std(torque, axis=0)
    together = np.mean((effort - effort.mean(axis=0)) * (torque - torque.mean(axis=0)), axis=0)
    alike = np.abs(together) > ALIKE * np.maximum(spread * size, 1e-300)
    moves = size > VARYING * size.max()
    return bool((spread < NOISE * size)[moves].all() and not alike[moves].any())


def _constant_joints(effort: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Return the joints whose effort stays the same while their torque does not."""
    varies = np.std(torque, axis=0)
    size = np.sqrt(np.mean(torque**2, axis=0))
    return np.flatnonzero((np.ptp(effort, axis=0) <= CONSTANT * varies)
                          & (varies > VARYING * np.maximum(size, SMALL_SHARE * size.max())))
