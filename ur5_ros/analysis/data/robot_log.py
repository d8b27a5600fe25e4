"""A robot's own log, as CSV, into a bag of the topics that runs have."""

import gzip
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.fixed_messages import FixedJointState, FixedPose, FixedTrajectoryPoint
from ur5_ros.config import CONTROL_PARAMETERS, arm_text, complete, load_arm
from ur5_ros.config.topics import CONTROL_NODE, CONTROL_TOPICS, ROBOT_TOPICS, by_role
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import quaternion_of, rotation_about
from ur5_ros.signals import JOINT_NAMES

#: A log of ten hours at 500 Hz is about this long [bytes].
MAX_BYTES = 4 << 30

#: Quantity -> how its six columns are called: the UR real-time interface as published by
#: K. Kufieta, and UR's RTDE recorder and ur_rtde.
COLUMNS = {
    'q': ('q_actual_{1}', 'actual_q_{0}'),
    'qd': ('qd_actual_{1}', 'actual_qd_{0}'),
    'torque': ('m_target_{1}', 'target_moment_{0}'),
    'q_star': ('q_target_{1}', 'target_q_{0}'),
    'qd_star': ('qd_target_{1}', 'target_qd_{0}'),
    'qdd_star': ('qdd_target_{1}', 'target_qdd_{0}'),
    'current': ('i_actual_{1}', 'actual_current_{0}'),
    'tool': ('tool_vector_{1}', 'actual_TCP_pose_{0}'),
}
_TIME = ('t', 'timestamp')
_NEEDED = ('q', 'qd')

_TOPICS = by_role((*CONTROL_TOPICS, *ROBOT_TOPICS))
_ROLES = ('joint_states', 'reference', 'motor_current', 'tool_pose')


class RobotLog(NamedTuple):
    """What a log says, row by row."""

    t: np.ndarray
    """Time [s], shape (n,), increasing."""
    values: dict[str, np.ndarray]
    """Quantity of :data:`COLUMNS` -> shape (n, 6), of those that the log has."""


def import_log(log: Path, out: Path, arm: str = 'ur5_controller') -> list[str]:
    """
    Turn a robot's log into a bag.

    Target position, velocity and acceleration become the reference; the target torque becomes the
    effort of the joint states, motor currents a topic of their own.

    Parameters
    ----------
    log : pathlib.Path
        CSV, separated by commas, semicolons, tabs or spaces, maybe gzipped.
    out : pathlib.Path
        Bag folder to write; it must not exist.
    arm : str
        Arm that the log is of.

    Returns
    -------
    list of str
        What was done, in sentences.

    Raises
    ------
    InputError
        If the log lacks columns, holds what is no number, or its time does not increase.

    """
    log, out = Path(log), Path(out)
    load_arm(arm)
    if out.exists():
        raise InputError(f'{out} exists already; give another folder')
    read = read_log(log)
    _write(read, log, out, arm)
    values = read.values
    unexplained_torque = [name for name in COLUMNS if name not in values]
    sentences = [f'{len(read.t)} samples over {read.t[-1] - read.t[0]:.6g} s, '
                 f'{1.0 / np.median(np.diff(read.t)):.4g} Hz']
    if 'torque' in values:
        sentences.append('effort = target torque of the robot, which belongs to its target motion')
    if unexplained_torque:
        sentences.append('not in the log: ' + ', '.join(
            COLUMNS[name][0].replace('{1}', '1..6') for name in unexplained_torque))
    return [*sentences, f'written: {out}']


def read_log(log: Path) -> RobotLog:
    """
    Return what a log says.

    Raises
    ------
    InputError
        As :func:`import_log`.

    """
    text = _text(log)
    head, _, body = text.partition('\n')
    separator = next((mark for mark in (',', ';', '\t') if mark in head), None)
    names = [name.strip().strip('"') for name in head.split(separator)]
    places = {name: i for i, name in enumerate(names)}
    if len(places) != len(names):
        double = next(name for name in names if names.count(name) > 1)
        raise InputError(f'{log}: column {double!r} stands twice; remove one')
    time = next((places[name] for name in _TIME if name in places), None)
    if time is None:
        raise InputError(f'{log}: no column {" or ".join(_TIME)}; the first columns are '
                         f'{", ".join(names[:4])[:80]!r}')
    found = {name: _places(forms, places) for name, forms in COLUMNS.items()}
    for name in _NEEDED:
        if found[name] is None:
            either, other = COLUMNS[name]
            raise InputError(f'{log}: no columns {either.replace("{1}", "1..6")} or '
                             f'{other.replace("{0}", "0..5")}; they are needed')
    if not body.strip():
        raise InputError(f'{log}: no rows under the names; at least two whole rows are needed')
    try:
        table = np.loadtxt(StringIO(body), delimiter=separator, ndmin=2)
    except ValueError as error:
        raise InputError(f'{log}: not a table of numbers: {str(error).splitlines()[0]}') from None
    if table.shape[0] < 2 or table.shape[1] != len(names):
        raise InputError(f'{log}: {table.shape[0]} rows of {table.shape[1]} numbers under '
                         f'{len(names)} names; at least two whole rows are needed')
    wanted = [time, *(i for columns in found.values() if columns for i in columns)]
    bad = ~np.isfinite(table[:, wanted]).all(axis=1)
    if bad.any():
        raise InputError(f'{log}: line {int(np.argmax(bad)) + 2} holds what is no number; '
                         'remove the line')
    t = table[:, time]
    if np.any(np.diff(t) <= 0.0):
        raise InputError(f'{log}: the time of line {int(np.argmax(np.diff(t) <= 0.0)) + 3} is not '
                         'after the one before; sort the log')
    return RobotLog(t, {name: table[:, columns] for name, columns in found.items() if columns})


def _text(log: Path) -> str:
    try:
        with open(log, 'rb') as plain:
            zipped = plain.read(2) == b'\x1f\x8b'
        with (gzip.open if zipped else open)(log, 'rb') as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, EOFError) as error:
        raise InputError(f'{log}: cannot be read: {getattr(error, "strerror", None) or error}'
                         ) from None
    if len(data) > MAX_BYTES:
        raise InputError(f'{log}: more than {MAX_BYTES} bytes; split it')
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError:
        raise InputError(f'{log}: not a text file; give CSV in UTF-8') from None


def _places(forms: tuple[str, str], places: dict[str, int]) -> list[int] | None:
    for form in forms:
        names = [form.format(i, i + 1) for i in range(6)]
        if all(name in places for name in names):
            return [places[name] for name in names]
    return None


def _write(read: RobotLog, log: Path, out: Path, arm: str) -> None:
    values = read.values
    reference = [values[name] for name in ('q_star', 'qd_star', 'qdd_star') if name in values]
    if 'q_star' not in values:
        reference = []
    parameters = complete(CONTROL_PARAMETERS, {'arm': arm, 'bag': ''})
    names = {role: _TOPICS[role].absolute(CONTROL_NODE) for role in _ROLES}
    description = describe('robot', out.resolve().name, arm, arm_text(arm), parameters, names,
                           fingerprint())
    description['log'] = log.name
    description['effort'] = 'target torque' if 'torque' in values else 'none'
    with_torque = ('effort',) if 'torque' in values else ()
    state = FixedJointState(JOINT_NAMES, fields=('position', 'velocity', *with_torque))
    star = FixedTrajectoryPoint(
        JOINT_NAMES, fields=FixedTrajectoryPoint.FIELDS[:len(reference)])
    current = FixedJointState(JOINT_NAMES, fields=('effort',))
    pose = FixedPose('base')
    stamps = np.rint((read.t - read.t[0]) * 1e9).astype(np.int64) + 1_000_000
    writer = BagWriter(out, description, max_duration=0.0, blocking=True)
    with writer:
        topics = {role: writer.topic(names[role], _TOPICS[role].type) for role in _ROLES}
        for k, stamp in enumerate(stamps.tolist()):
            effort = values['torque'][k] if with_torque else ()
            writer.write(topics['joint_states'], stamp,
                         state.encode(stamp, values['q'][k], values['qd'][k], effort))
            if reference:
                writer.write(topics['reference'], stamp,
                             star.encode(stamp, *(part[k] for part in reference)))
            if 'current' in values:
                writer.write(topics['motor_current'], stamp,
                             current.encode(stamp, (), (), values['current'][k]))
            if 'tool' in values:
                writer.write(topics['tool_pose'], stamp, pose.encode(
                    stamp, values['tool'][k][:3], _quaternion(values['tool'][k][3:])))
        writer.note('summary', {'reason': f'imported from {log.name}', 'periods': len(stamps)})
    if writer.failure:
        raise InputError(f'{out}: {writer.failure}')


def _quaternion(vector: np.ndarray) -> np.ndarray:
    """Return the quaternion of a rotation vector."""
    angle = float(np.linalg.norm(vector))
    return quaternion_of(rotation_about(vector / (angle or 1.0), angle))
