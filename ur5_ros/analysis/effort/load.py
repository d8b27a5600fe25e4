"""What a recorded effort means where the tool carries an unknown load."""

from dataclasses import replace

import numpy as np

from ur5_ros.analysis.effort.fit import (
    fit_current,
    friction_columns,
    misfit_of,
    relative_size,
    torque_of,
)
from ur5_ros.analysis.effort.meanings import Hypothesis
from ur5_ros.analysis.residual_blocks import SampleBlocks
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor

#: Times that load and factors are fitted in turn.
LOAD_PASSES = 8


def meanings_with_load(samples: SampleBlocks, arm: ArmParameters) -> list[Hypothesis]:
    """Return the meanings of the effort, each with the load that fits best; joint torque first."""
    effort, weightless = samples.effort.mean(axis=1), replace(arm, gravity=np.zeros(3))
    rest = samples._replace(qd=np.zeros_like(samples.qd), qdd=np.zeros_like(samples.qdd))
    return [_with_load('total', effort, samples, samples, arm),
            _with_load('gravity_excluded', effort, samples, samples, weightless),
            _with_load('target', effort, samples, rest, arm),
            _with_load('other_sign', -effort, samples, samples, arm),
            _current_with_load(effort, samples, arm)]


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


def _load_columns(samples: SampleBlocks, arm: ArmParameters) -> np.ndarray:
    """Return the torque of a unit of the ten parameters of a load at the tool, (b, 6, 10)."""
    return dynamics_regressor(samples.q, samples.qd, samples.qdd, arm)[..., 50:].mean(axis=1)
