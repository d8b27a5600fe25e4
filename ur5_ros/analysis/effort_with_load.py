"""What an effort is that fits no meaning as it is: with an unknown load, or no measurement."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.effort import (
    CLEARLY_BETTER,
    CONSTANT,
    SMALL_SHARE,
    VARYING,
    Hypothesis,
    fit_current,
    friction_columns,
    is_plausible_current,
    misfit_of,
    relative_size,
    torque_of,
)
from ur5_ros.analysis.residual_blocks import SampleBlocks, sample_blocks
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor

#: Heaviest load that is looked for [kg]: three times what the strongest of the family carries.
HEAVIEST_LOAD = 100.0

#: An effort that varies by less than this share of the torque, and correlates less, is noise.
NOISE, ALIKE = 0.1, 0.5

#: Times that load and factors are fitted in turn.
LOAD_PASSES = 8


def unlikely_meaning(run: Run, arm: ArmParameters, limit: float) -> Hypothesis | None:
    """
    Return what an effort is that fits no meaning as it is; None where nothing better is found.

    The meanings with an unknown load at the tool, then joints that are exchanged, then joints
    whose effort stays the same while they move.

    """
    samples = sample_blocks(replace(run, follows_reference=False), arm)
    if samples is None or not np.abs(samples.qd).max() > 0.0:
        return None
    rest = samples._replace(qd=np.zeros_like(samples.qd), qdd=np.zeros_like(samples.qdd))
    weightless = replace(arm, gravity=np.zeros(3))
    effort = samples.effort.mean(axis=1)
    found = [_with_load('total', effort, samples, samples, arm),
             _with_load('gravity_excluded', effort, samples, samples, weightless),
             _with_load('target', effort, samples, rest, arm),
             _with_load('other_sign', -effort, samples, samples, arm),
             _current_with_load(effort, samples, arm)]
    best = min(found, key=lambda each: each.misfit)
    likely = 0.0 < best.load <= HEAVIEST_LOAD and (
        best.meaning != 'current' or is_plausible_current(best))
    if likely and best.misfit <= min(0.5 * limit, 0.5 * CLEARLY_BETTER * found[0].misfit):
        return best
    exchanged = min(_exchanged(samples, arm), key=lambda each: each.misfit)
    if exchanged.misfit <= min(0.5 * limit, 0.5 * CLEARLY_BETTER * found[0].misfit):
        return exchanged
    torque = torque_of(samples, arm)
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


def _load_columns(samples: SampleBlocks, arm: ArmParameters) -> np.ndarray:
    """Return the torque of a unit of the ten parameters of a load at the tool, (b, 6, 10)."""
    return dynamics_regressor(samples.q, samples.qd, samples.qdd, arm)[..., 50:].mean(axis=1)


def _with_load(meaning: str, effort: np.ndarray, samples: SampleBlocks, moved: SampleBlocks,
               arm: ArmParameters) -> Hypothesis:
    """Return a meaning with the load that fits best, friction beside it."""
    torque = inverse_dynamics(moved.q, moved.qd, moved.qdd, arm).mean(axis=1)
    columns = _load_columns(moved, arm)
    friction = friction_columns(samples)[:, :, None, :] * np.eye(6)[None, :, :, None]
    x = np.concatenate([columns, friction.reshape(*columns.shape[:2], 12)], axis=-1)
    x, y = x.reshape(-1, 22), (effort - torque).ravel()
    use = np.ones(22, dtype=bool)
    for _ in range(LOAD_PASSES):
        value, *_ = np.linalg.lstsq(x * use, y, rcond=1e-10)
        drives = use & (value < 0.0) & (np.arange(22) >= 10)  # friction drives no joint
        if not drives.any():
            break
        use &= ~drives
    return Hypothesis(meaning, misfit_of(effort, torque + columns @ value[:10], samples),
                      load=float(value[0]))


def _current_with_load(effort: np.ndarray, samples: SampleBlocks,
                       arm: ArmParameters) -> Hypothesis:
    """Return motor current of an arm with a load: factors and load fitted in turn."""
    torque, columns = torque_of(samples, arm), _load_columns(samples, arm)
    load, factors, model = np.zeros(10), np.full(6, np.nan), np.zeros_like(effort)
    for _ in range(LOAD_PASSES):
        factors, model = fit_current(effort, torque + columns @ load, samples)
        known = np.isfinite(factors)
        missing = (effort - model) * np.where(known, factors, 0.0)
        # a step along the load with the factors free to follow it
        slope = np.stack([_follow(columns[..., i], torque + columns @ load, samples)
                          for i in range(10)], axis=-1)
        step, *_ = np.linalg.lstsq((slope * known[:, None]).reshape(-1, 10), missing.ravel(),
                                   rcond=1e-8)
        load = load + step
    return Hypothesis('current', relative_size(effort - model, effort), tuple(factors.tolist()),
                      float(load[0]))


def _follow(column: np.ndarray, torque: np.ndarray, samples: SampleBlocks) -> np.ndarray:
    """Return what of a change of the torque a factor and friction of each joint do not follow."""
    friction, left = friction_columns(samples), np.empty_like(column)
    for joint in range(6):
        x = np.column_stack([torque[:, joint], friction[:, joint]])
        left[:, joint] = column[:, joint] - x @ np.linalg.lstsq(x, column[:, joint],
                                                                 rcond=1e-10)[0]
    return left


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
