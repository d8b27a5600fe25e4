"""An excitation trajectory as an experiment file, and as a JointTrajectory."""

import json
from pathlib import Path

import numpy as np

from ur5_ros.config.experiments import JointWaves
from ur5_ros.control.profiles import joint_waves
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

#: Points of the JointTrajectory a second; between them it is interpolated by quintics.
POINTS = 10.0


def write_excitation(experiment: JointWaves, path: Path) -> Path:
    """
    Write an experiment file, and beside it the same motion as a JointTrajectory.

    ``path``: experiment file; ``x.yaml`` has ``x.trajectory.yaml`` beside it.  Returned: the file
    of the JointTrajectory, for ``ros2 topic pub``.
    """
    beside = path.with_suffix('.trajectory.yaml')
    refuse_existing(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for file, text in ((path, experiment_yaml(experiment)),
                           (beside, trajectory_yaml(experiment))):
            with open(file, 'x', encoding='utf-8') as out:
                out.write(text)
    except OSError as error:
        raise InputError(f'{path}: cannot be written: {error.strerror}') from None
    return beside


def refuse_existing(path: Path) -> None:
    """Raise :class:`~ur5_ros.errors.InputError` where one of the two files exists."""
    for file in (path, path.with_suffix('.trajectory.yaml')):
        if file.exists():
            raise InputError(f'{file} exists; give another file, or remove it')


def experiment_yaml(experiment: JointWaves) -> str:
    """Return the text of an experiment file."""
    lines = [f'name: {experiment.name}', f'description: {json.dumps(experiment.description)}',
             f'source: {json.dumps(experiment.source)}', 'kind: joint_waves',
             f'duration: {experiment.duration!r}', f'ramp: {experiment.ramp!r}',
             f'ramp_down: {experiment.ramp_down!r}',
             'start_degrees: [' + ', '.join(f'{x:.9g}' for x in experiment.start_degrees) + ']',
             'joints:']
    for name, waves in experiment.joints.items():
        lines.append(f'  {name}:')
        lines += [f'    - {{amplitude: {wave.amplitude:.9g}, frequency: {wave.frequency:.12g}, '
                  f'phase_degrees: {wave.phase_degrees:.9g}}}' for wave in waves]
    return '\n'.join(lines) + '\n'


def trajectory_yaml(experiment: JointWaves) -> str:
    """Return the motion as the YAML text of a trajectory_msgs/JointTrajectory."""
    t = np.linspace(0.0, experiment.duration, round(experiment.duration * POINTS) + 1)
    motion = joint_waves(t, experiment)
    lines = ['joint_names: [' + ', '.join(JOINT_NAMES) + ']', 'points:']
    for k, time in enumerate(t):
        seconds = int(time)
        lines += [f'- positions: {_numbers(motion.q[k])}',
                  f'  velocities: {_numbers(motion.qd[k])}',
                  f'  accelerations: {_numbers(motion.qdd[k])}',
                  f'  time_from_start: {{sec: {seconds}, '
                  f'nanosec: {round((time - seconds) * 1e9)}}}']
    return '\n'.join(lines) + '\n'


def _numbers(values: np.ndarray) -> str:
    return '[' + ', '.join(f'{value:.9g}' for value in values) + ']'
