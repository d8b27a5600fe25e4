"""A robot that compensates more or less than its friction, and the vibration that follows."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.compensation import robot_compensation
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.plant_integrator import plant_models
from ur5_ros.analysis.residual import residual
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.model.friction import JointFriction
from ur5_ros.signals import JOINT_NAMES

#: A compensation within this share of the friction is taken for whole.
WHOLE_SHARE = 0.01

#: Speed from which on friction and its compensation are compared [rad/s].
MOVING_SPEED = 0.02

#: Name of the check.
NAME = 'friction compensation'


class Compensation(NamedTuple):
    """How much of each joint's friction a robot compensated."""

    share: np.ndarray
    """Of the friction that the motion shows, shape (6,); NaN for a joint that did not move."""
    total: float
    """The same over all joints."""


def compensated(run: Run) -> Compensation | None:
    """Return how much of its friction the robot compensated; None where it compensates none."""
    added = robot_compensation(run)
    if added is None or not run.substeps or run.noisy:
        return None
    frictionless = [(row, replace(model, friction=JointFriction()))
                    for row, model in plant_models(run)]
    friction = -residual(run, frictionless).torque
    use = (np.abs(run.exact.qd[1:]) > MOVING_SPEED) & np.isfinite(friction)
    both = np.where(use, added * friction, 0.0).sum(axis=0)
    power = np.where(use, friction**2, 0.0).sum(axis=0)
    moved = power > 1e-6 * power.max()
    share = np.where(moved, both / np.where(moved, power, 1.0), np.nan)
    return Compensation(share, float(both[moved].sum() / power[moved].sum())) if (
        moved.any() and power.max() > 0.0) else None


def compensation_check(run: Run) -> Check:
    """Return whether the robot takes off no more friction than it has."""
    found = compensated(run)
    if found is None:
        return not_applicable(NAME, 'no joint with compensated friction moved')
    joint = int(np.nanargmax(found.share))
    swing = limit_cycle(run) if found.share[joint] > 1.0 + WHOLE_SHARE else None
    words = f'; {swing["sentence"]}' if swing else ''
    return judge(NAME, float(found.share[joint]), 1.0 + WHOLE_SHARE, '1',
                 f'the robot adds {found.total:.1%} of the friction that the motion shows, '
                 f'{found.share[joint]:.1%} at {JOINT_NAMES[joint]}{words}',
                 joint=JOINT_NAMES[joint])


def compensation_cause(run: Run) -> dict[str, Any] | None:
    """Return the cause where a robot compensates more or less than its friction."""
    found = compensated(run)
    if found is None:
        return None
    over, under = found.share > 1.0 + WHOLE_SHARE, found.share < 1.0 - WHOLE_SHARE
    if not (over | under).any():
        return None
    kind, named = ('over-compensation', over) if over.any() else ('under-compensation', under)
    joints = {JOINT_NAMES[i]: {'value': float(found.share[i])} for i in np.flatnonzero(named)}
    listed = ', '.join(f'{name} {each["value"]:.1%}' for name, each in joints.items())
    amount, effect = (('more', 'a moving joint accelerates') if over.any() else
                      ('less', 'the law has to supply the rest'))
    cause = {'kind': kind, 'times': found.total, 'joints': joints, 'share': 1.0,
             'sentence': f'{kind}: the robot adds {amount} than the friction that the motion '
             f'shows ({listed}), so that {effect}; over all joints it adds {found.total:.1%}'}
    if over.any() and (swing := limit_cycle(run)):
        cause |= {'limit_cycle': {name: swing[name] for name in ('joint', 'hz', 'velocity')},
                  'sentence': f'{cause["sentence"]}; {swing["sentence"]}'}
    return cause


def limit_cycle(run: Run) -> dict[str, Any] | None:
    """Return the swing that goes on to the end of a run and that no reference asks for."""
    last = slice(len(run.stamp) // 2, None)
    qd = run.exact.qd[last]
    if run.reference is not None:
        qd = qd - np.nan_to_num(run.reference.qd[last])
    size = np.abs(qd).max(axis=0)
    joint = int(np.argmax(size))
    fast = qd[np.abs(qd[:, joint]) > 0.1 * size[joint], joint]
    turns = int((np.diff(np.sign(fast)) != 0).sum())
    if size[joint] < MOVING_SPEED or turns < 4:
        return None
    hz = 0.5 * turns / (len(qd) * run.h)
    return {'joint': JOINT_NAMES[joint], 'hz': hz, 'velocity': float(size[joint]),
            'sentence': f'a limit cycle: {JOINT_NAMES[joint]} swings at {hz:.2g} Hz with up to '
            f'{size[joint]:.2g} rad/s to the end'}
