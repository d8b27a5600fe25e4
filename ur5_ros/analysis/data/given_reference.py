"""A reference that the user names, for a recording that holds none."""

from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.bag.reader import Bag, open_bag
from ur5_ros.bag.run_folders import bags_of_run
from ur5_ros.config.experiments import list_experiments, load_experiment
from ur5_ros.control.experiment import experiment_trajectory
from ur5_ros.errors import InputError
from ur5_ros.model.inverse_kinematics import nearest_solution
from ur5_ros.model.rotations import rotation_of_quaternion
from ur5_ros.signals import JOINT_NAMES, Reference

#: Message types that a reference may have, and their field of positions.
_FIELDS = {'trajectory_msgs/msg/JointTrajectory': ('positions', 'velocities', 'accelerations'),
           'sensor_msgs/msg/JointState': ('position', 'velocity', '')}


def given_reference(run: Run, text: str) -> Reference:
    """
    Return the reference that a text names, for every state of a run.

    ``text``: A topic (``/...``) of one of its bags; an experiment, by name or file, that begins
    with the first state; six joint angles [rad]; or a tool pose in ``base``: x, y, z [m] and a
    quaternion x, y, z, w.  Returned: shapes (n, 6); NaN before the first message of a topic.
    """
    if text.startswith('/'):
        return _of_topic(run, text)
    if text in list_experiments() or text.endswith(('.yaml', '.yml')):
        return _of_experiment(run, text)
    numbers = _numbers(text)
    if len(numbers) == 6:
        return _constant(run, np.array(numbers))
    if len(numbers) == 7:
        return _constant(run, _joints_of_pose(run, np.array(numbers)))
    raise InputError(f'--reference {text!r}: give a topic such as /ur5_control/reference, an '
                     f'experiment ({", ".join(list_experiments())}), six joint angles [rad], or '
                     'a tool pose of seven numbers x,y,z,qx,qy,qz,qw')


def _numbers(text: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.replace(',', ' ').split()]
    except ValueError:
        return []
    return numbers if np.isfinite(numbers).all() else []


def _constant(run: Run, q: np.ndarray) -> Reference:
    still = np.zeros((len(run.stamp), 6))
    return Reference(np.broadcast_to(q, still.shape).copy(), still, still.copy())


def _joints_of_pose(run: Run, pose: np.ndarray) -> np.ndarray:
    """Return the joint angles at the pose that are nearest to where the run ended."""
    norm = float(np.linalg.norm(pose[3:]))
    if abs(norm - 1.0) > 1e-3:
        raise InputError(f'--reference: the quaternion has the norm {norm:.4g}; give norm 1')
    record = run.law_record
    if record is None:
        raise InputError('--reference with a pose needs an arm; give one: --arm NAME')
    arm, transform = record.arm, np.eye(4)
    transform[:3, :3], transform[:3, 3] = rotation_of_quaternion(pose[3:] / norm), pose[:3]
    near = run.exact.q[-1] + arm.angle_offset
    return nearest_solution(transform, near, arm) - arm.angle_offset


def _of_experiment(run: Run, name: str) -> Reference:
    record = run.law_record
    if record is None:
        raise InputError('--reference with an experiment needs an arm; give one: --arm NAME')
    trajectory = experiment_trajectory(load_experiment(name), record.arm, round(run.control_rate),
                                   0.0).trajectory
    time = np.minimum(run.stamp - run.stamp[0], trajectory.duration).tolist()
    return Reference(*np.moveaxis(np.array([trajectory.at(each) for each in time]), 1, 0))


def _of_topic(run: Run, topic: str) -> Reference:
    """Return the newest message at each state: of its stamp, or before it."""
    columns, fields = _read_topic(Path(run.folder), topic)
    order = np.argsort(columns.stamp, kind='stable')
    newest = np.searchsorted(columns.stamp[order], run.stamp, side='right') - 1
    rows = order[np.maximum(newest, 0)]
    parts = []
    for field in fields:
        values = columns.fields[field][rows] if field else np.full((len(rows), 6), np.nan)
        parts.append(np.where((newest >= 0)[:, None], values, np.nan))
    q, qd, qdd = parts
    return Reference(q, *(np.where(np.isfinite(part) | np.isnan(q), part, 0.0)
                          for part in (qd, qdd)))


def _read_topic(folder: Path, topic: str) -> tuple[Columns, tuple[str, ...]]:
    known: list[str] = []
    for path in bags_of_run(folder):
        bag = open_bag(path)
        known += [name for name, kind in bag.topics.items() if kind in _FIELDS]
        if topic in known:
            return _columns(bag, topic)
    raise InputError(f'--reference {topic}: no such topic of joint positions in {folder}; there '
                     f'are: {", ".join(sorted(set(known))) or "none"}')


def _columns(bag: Bag, topic: str) -> tuple[Columns, tuple[str, ...]]:
    columns = bag.load({topic: JOINT_NAMES})[topic]
    if not len(columns.stamp):
        raise InputError(f'--reference {topic}: no message of it in {bag.path} names the joints '
                         f'{", ".join(JOINT_NAMES)}')
    return columns, _FIELDS[bag.topics[topic]]
