"""
The model against recordings of a real UR5: the figures of docs/real_robot.md.

    python benchmarks/real_ur5.py FOLDER

FOLDER holds motion3_fast.csv.gz and three more (docs/real_robot.md says where they come from).
"""

import argparse
import gzip
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from side_by_side import Row, publish

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.logs.robot_log import import_log
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix, inverse_dynamics
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor, inertial_parameters
from ur5_ros.model.rotations import rotation_vector

MOTIONS = ('motion3_fast', 'motion5_slow', 'motion6_long', 'motion7_short')
#: Rows a second.
RATE = 125
Recording = Callable[[str], np.ndarray]


def recording(path: Path) -> Recording:
    """Return a function: prefix of six columns -> their values, shape (n, 6)."""
    with gzip.open(path, 'rt') as file:
        names = file.readline().strip().split(',')
        data = np.loadtxt(file, delimiter=',')
    return lambda prefix: data[:, [names.index(f'{prefix}_{i}') for i in range(1, 7)]]


def matrices(vectors: np.ndarray) -> np.ndarray:
    """Return the matrices of rotation vectors."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = (vectors / angle[:, 0]).T
    zero = np.zeros_like(x)
    k = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)


def kinematics(column: Recording) -> dict[str, float]:
    """Return the largest distance of the tool from where the robot says it is [m, rad]."""
    pose, tool = forward_kinematics(column('q_actual'), load_arm('ur5')), column('tool_vector')
    turn = rotation_vector(pose[:, :3, :3].swapaxes(1, 2) @ matrices(tool[:, 3:]))
    off = np.linalg.norm(pose[:, :3, 3] - tool[:, :3], axis=1)
    return {'samples': len(pose), 'position': float(off.max()),
            'rotation': float(np.linalg.norm(turn, axis=1).max())}


def gravity(column: Recording) -> dict[str, float]:
    """Return the gravity that the robot holds at rest, and what is left of the torque [N m]."""
    still = np.all((column('qd_target') == 0.0) & (column('qdd_target') == 0.0), axis=1)
    unit = gravity_torque(column('q_target')[still], load_arm('ur5_controller')) / 9.82
    held = column('m_target')[still]
    fitted = float(np.sum(unit * held) / np.sum(unit * unit))
    return {'samples': int(still.sum()), 'g': fitted,
            'left': float(np.abs(fitted * unit - held).max()),
            'left with 9.81': float(np.abs(9.81 * unit - held).max())}


def left_over(column: Recording, arm: ArmParameters, fit: bool) -> list[float]:
    """Return the RMS of what the arm without rotors leaves, or with rotors fitted [N m]."""
    q, qd, qdd = column('q_target'), column('qd_target'), column('qdd_target')
    rest = column('m_target') - dynamics_regressor(q, qd, qdd, arm) @ inertial_parameters(arm)
    if fit:
        rest = rest - np.sum(qdd * rest, axis=0) / np.sum(qdd**2, axis=0) * qdd
    return np.sqrt(np.mean(rest**2, axis=0)).tolist()


def rotors(column: Recording, arm: ArmParameters) -> dict[str, list[float]]:
    """
    Return rotor inertia and its standard error, by least squares [kg m^2].

    What is left over is no white noise: the error comes from its sums over whole seconds.
    """
    q, qd, qdd = column('q_target'), column('qd_target'), column('qdd_target')
    rest = column('m_target') - dynamics_regressor(q, qd, qdd, arm) @ inertial_parameters(arm)
    power = np.sum(qdd**2, axis=0)
    fitted = np.sum(qdd * rest, axis=0) / power
    score = np.add.reduceat(qdd * (rest - fitted * qdd), np.arange(0, len(q), RATE), axis=0)
    return {'fitted': fitted.tolist(),
            'error': (np.sqrt(np.sum(score**2, axis=0)) / power).tolist()}


def friction(folder: Path) -> dict[str, Any]:
    """Return torque constants and friction, fitted to all motions but the fast one."""
    with tempfile.TemporaryDirectory() as place:
        runs = {}
        for name in MOTIONS:
            import_log(folder / f'{name}.csv.gz', Path(place) / name, 'ur5_controller')
            runs[name] = load_run(Path(place) / name)
        return identify([runs[name] for name in MOTIONS[1:]], load_arm('ur5_controller'),
                        runs[MOTIONS[0]]).to_plain()['motors']['joints']


def main() -> None:
    """Compute and keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('folder', type=Path)
    folder = parser.parse_args().folder
    columns = {name: recording(folder / f'{name}.csv.gz') for name in MOTIONS}
    arm = load_arm('ur5_controller')
    fast = columns['motion3_fast']
    poses = {name: kinematics(column) for name, column in columns.items()}
    torque = {}
    for name, column in columns.items():
        error = inverse_dynamics(column('q_target'), column('qd_target'), column('qdd_target'),
                                 arm) - column('m_target')
        torque[name] = np.sqrt(np.mean(error**2, axis=0)).tolist()
    inertia = float(inertia_matrix(np.zeros(6), load_arm('ur5'))[5, 5])
    bare = arm.armature[5] / inertia
    publish('real_ur5', 'The model against recordings of a real UR5', [
        Row('tool position, the worst sample', '2 micrometres',
            max(each['position'] for each in poses.values()) / 2e-6, 1.0, False),
        Row('torque of the controller, RMS, the worst joint', '0.005 N m',
            max(map(max, torque.values())) / 0.005, 1.0, False),
    ], {'kinematics': poses, 'torque': torque, 'gravity': gravity(columns['motion6_long']),
        'largest torque': {name: float(np.abs(column('m_target')).max())
                           for name, column in columns.items()},
        'rotors': {name: rotors(column, arm) for name, column in columns.items()},
        'friction': friction(folder),
        'without rotors': left_over(fast, arm, fit=False),
        'with tensors': left_over(fast, replace(arm, inertia=load_arm('ur5').inertia), fit=True),
        'M66': inertia, 'rotors over M66': bare})


if __name__ == '__main__':
    main()
