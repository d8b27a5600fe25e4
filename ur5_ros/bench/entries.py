"""The laws of the bench with their gains: two numbers and the law's own one, as parameters."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.bench.perturbations import ARM
from ur5_ros.config import load_arm
from ur5_ros.config.parameters import HOME
from ur5_ros.config.records import Record, validate
from ur5_ros.config.strict_yaml import config_folder, read_yaml
from ur5_ros.control.laws.user_law import load_law
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.kinematics import forward_kinematics, jacobian


class Entry(NamedTuple):
    """A law with its gains; small enough to travel to a worker."""

    name: str
    control: dict[str, Any]
    """Parameters of the controller."""
    timeout: float = 0.0
    """Wall-clock time of a run, which has a process of its own [s]; 0 = it has none."""


class Tuned(Record, frozen=True):
    """Gains of a law as the search found them."""

    frequency: float
    """Natural frequency of the error [rad/s]."""
    damping: float
    """Its damping ratio."""
    own: float
    """The law's own number as a multiple of its usual one."""


class Candidate(Record, frozen=True):
    """Gains that the search tried, and what came of them."""

    law: str
    frequency: float
    damping: float
    own: float
    cost: float
    survived: int
    rms_error: float | None
    """Mean over the conditions survived [rad]; None where there was none."""
    roughness: float | None
    """Mean over the conditions survived [N m/s]."""


class BenchFile(Record, frozen=True):
    """What ``config/bench.yaml`` holds, written by ``ur5 bench --tune``."""

    how: str
    laws: dict[str, Tuned]
    tried: list[Candidate]


#: Modes whose gains carry the inertia themselves.
_UNWEIGHTED_MODES = ('pd', 'gravity_pd', 'impedance', 'pid')

#: Laws of the bench.
LAWS = ('pd', 'gravity_pd', 'pid', 'impedance', 'computed_torque', 'computed_torque_integral',
        'computed_torque+observer', 'slotine_li', 'adaptive', 'sliding_mode',
        'cartesian_impedance')


def entry_of(name: str, gains: Tuned) -> Entry:
    """
    Return a law with gains that give its error a frequency and a damping.

    KP = w^2 and KD = 2 zeta w where the law weighs by M; times the inertia of the arm at home
    where it does not.
    """
    w, own = gains.frequency, gains.own
    kp, kd = w**2, 2.0 * gains.damping * w
    mode, _, extra = name.partition('+')
    control: dict[str, Any] = {'mode': mode, 'kp': [kp], 'kd': [kd]}
    arm = load_arm(ARM)
    home = np.array(HOME) + arm.angle_offset
    inertia = inertia_matrix(home, arm)
    if mode in _UNWEIGHTED_MODES:
        joints = np.diag(inertia)
        control |= {'kp': (kp * joints).tolist(), 'kd': (kd * joints).tolist()}
        if mode == 'pid':
            control['ki'] = (0.2 * own * w * kp * joints).tolist()
    elif mode == 'computed_torque_integral':
        control['ki'] = [0.2 * own * w * kp]
    elif mode == 'adaptive':
        control['adaptation_rate'] = 300.0 * own
    elif mode == 'sliding_mode':
        control['boundary_layer'] = [0.5 * own]
    elif mode == 'cartesian_impedance':
        turn = np.kron(np.eye(2), forward_kinematics(home, arm)[:3, :3])
        along = turn.T @ jacobian(home, arm)
        felt = 1.0 / np.diag(along @ np.linalg.solve(inertia, along.T))
        control = {'mode': mode, 'impedance.stiffness': (kp * felt).tolist(),
                   'impedance.damping': (kd * felt).tolist()}
    if extra == 'observer':
        control |= {'disturbance_observer': True, 'observer_gain': 20.0 * own}
    return Entry(name, control)


def load_bench(path: Path | None = None) -> BenchFile:
    """Return the tuned gains, those of the package by default; InputError if they are wrong."""
    path = path or config_folder() / 'bench.yaml'
    found = validate(BenchFile, read_yaml(path), str(path))
    unknown = sorted(set(LAWS) ^ set(found.laws))
    if unknown:
        raise InputError(f'{path}: {unknown[0]} is unknown or missing; give {", ".join(LAWS)}')
    return found


def load_entries(gains: Path | None = None) -> list[Entry]:
    """Return the laws with gains of a file that ``ur5 bench --tune`` wrote, or the package's."""
    tuned = load_bench(gains).laws
    return [entry_of(name, tuned[name]) for name in LAWS]


def user_entry(file: str, gains: Path | None = None) -> Entry:
    """
    Return the law of a user's file, which is imported here.

    ``file``: A Python file with a class ``Law``.  It gets the gains of ``computed_torque``, or,
    where its class says ``weighed = False``, those of ``gravity_pd``.
    """
    like = 'computed_torque' if getattr(load_law(file), 'weighed', True) else 'gravity_pd'
    control = entry_of(like, load_bench(gains).laws[like]).control
    return Entry(Path(file).name, {**control, 'mode': 'computed_torque',
                                   'law_file': str(Path(file).resolve())})
