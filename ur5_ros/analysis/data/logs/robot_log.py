"""A robot's own log, as CSV, into a bag of the topics that runs have."""

from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.logs.columns import COLUMNS
from ur5_ros.analysis.data.logs.table import LogTable, read_table
from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.fixed_messages import (
    FixedJointState,
    FixedPose,
    FixedTrajectoryPoint,
    encode,
)
from ur5_ros.config import CONTROL_PARAMETERS, arm_text, complete, load_arm
from ur5_ros.config.topics import CONTROL_NODE, CONTROL_TOPICS, ROBOT_TOPICS, by_role
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import quaternion_of, rotation_about
from ur5_ros.signals import JOINT_NAMES

__all__ = ['COLUMNS', 'import_log']

_TOPICS = by_role((*CONTROL_TOPICS, *ROBOT_TOPICS))
_ROLES = ('joint_states', 'reference', 'motor_current', 'joint_temperature', 'tool_pose')

#: Temperatures are written this often [s]; a joint needs minutes to warm up.
TEMPERATURE_PERIOD = 1.0


def import_log(
    log: Path, out: Path, arm: str = 'ur5_controller', columns: str | None = None,
) -> list[str]:
    """
    Turn a robot's log into a bag.

    Target position, velocity and acceleration become the reference; the target torque becomes the
    effort of the joint states, a measured one where there is no other; motor currents become a
    topic of their own, a declared payload part of the arm.

    ``out``: bag folder to write; it must not exist; ``columns``: names of the columns in the order
    of the file, for one without names; ``-`` skips one.
    """
    log, out = Path(log), Path(out)
    load_arm(arm)
    if out.exists():
        raise InputError(f'{out} exists already; give another folder')
    table = read_table(log, columns)
    measured = table.values.pop('torque_actual', None)
    if measured is not None:
        table.values['torque'] = measured
    text, sentences = _arm_of(table, arm)
    effort = 'none' if 'torque' not in table.values else (
        'target torque' if measured is None else 'measured torque')
    _write(table, log, out, arm, text, effort)
    missing = [name for name in COLUMNS
               if name not in table.values and name != 'torque_actual']
    sentences = [f'{len(table.t)} samples over {table.t[-1] - table.t[0]:.6g} s, '
                 f'{1.0 / np.median(np.diff(table.t)):.4g} Hz', *table.remarks, *sentences]
    if effort == 'target torque':
        sentences.append('effort = target torque of the robot, which belongs to its target motion')
    elif effort == 'measured torque':
        sentences.append('effort = torque that the robot measured')
    if missing:
        sentences.append('not in the log: ' + ', '.join(
            COLUMNS[name][0].replace('{1}', '1..6') for name in missing))
    return [*sentences, f'written: {out}']


def _arm_of(table: LogTable, arm: str) -> tuple[str, list[str]]:
    """Return the text of the arm's file with the log's payload in it, and what was done."""
    text = arm_text(arm)
    if 'payload' not in table.values:
        return text, []
    masses = table.values['payload'][:, 0]
    values, counts = np.unique(masses, return_counts=True)
    mass = float(values[np.argmax(counts)])
    sentences = []
    if len(values) > 1:
        sentences.append(f'the declared payload changes from {masses.min():.4g} to '
                         f'{masses.max():.4g} kg; {mass:.4g} kg, in most rows, was taken')
    if mass < 0.0:
        sentences.append(f'the declared payload is {mass:.4g} kg, which none has: it was left out')
    if mass <= 0.0:
        return text, sentences
    com = np.zeros(3)
    if 'payload_com' in table.values:
        com = np.median(table.values['payload_com'][masses == mass], axis=0)
    if any(line.startswith('payload:') for line in text.splitlines()):
        return text, [*sentences, 'the arm file states a payload; that of the log was left out']
    numbers = ', '.join(repr(float(each)) for each in com)
    text = text.rstrip('\n') + (f'\npayload:\n  mass: {mass!r}\n  com: [{numbers}]\n'
                                f'  source: "declared in the log"\n')
    return text, [*sentences, f'declared payload: {mass:.4g} kg with its centre at '
                  f'[{", ".join(f"{each:.4g}" for each in com)}] m']


def _write(table: LogTable, log: Path, out: Path, arm: str, text: str, effort: str) -> None:
    values = table.values
    reference = [values[name] for name in ('q_star', 'qd_star', 'qdd_star') if name in values]
    if 'q_star' not in values:
        reference = []
    parameters = complete(CONTROL_PARAMETERS, {'arm': arm, 'bag': ''})
    names = {role: _TOPICS[role].absolute(CONTROL_NODE) for role in _ROLES}
    description = describe('robot', out.resolve().name, arm, text, parameters, names,
                           fingerprint())
    description['log'] = log.name
    description['effort'] = effort
    filled = [field for field, name in (('position', 'q'), ('velocity', 'qd'),
                                        ('effort', 'torque')) if name in values]
    state = FixedJointState(JOINT_NAMES, fields=filled)
    columns = [values[name] for name in ('q', 'qd', 'torque') if name in values]
    star = FixedTrajectoryPoint(
        JOINT_NAMES, fields=FixedTrajectoryPoint.FIELDS[:len(reference)])
    current = FixedJointState(JOINT_NAMES, fields=('effort',))
    pose = FixedPose('base')
    stamps, dropped = (np.rint((times - table.t[0]) * 1e9).astype(np.int64) + 1_000_000
                       for times in (table.t, table.dropped))
    writer = BagWriter(out, description, max_duration=0.0, blocking=True)
    with writer:
        topics = {role: writer.topic(names[role], _TOPICS[role].type) for role in _ROLES}
        warm = _temperature_rows(table)
        for k, stamp in enumerate(stamps.tolist()):
            parts = dict(zip(filled, (column[k] for column in columns), strict=True))
            writer.write(topics['joint_states'], stamp, state.encode(stamp, **parts))
            if reference:
                writer.write(topics['reference'], stamp,
                             star.encode(stamp, *(part[k] for part in reference)))
            if 'current' in values:
                writer.write(topics['motor_current'], stamp,
                             current.encode(stamp, (), (), values['current'][k]))
            if k in warm:
                writer.write(topics['joint_temperature'], stamp, encode(
                    _TOPICS['joint_temperature'].type, {'data': values['temperature'][k]}))
            if 'tool' in values:
                writer.write(topics['tool_pose'], stamp, pose.encode(
                    stamp, values['tool'][k][:3], _quaternion(values['tool'][k][3:])))
        writer.note('dropped', {'stamps': dropped.tolist(), 'remarks': table.remarks})
        writer.note('summary', {'reason': f'imported from {log.name}', 'periods': len(stamps)})
    if writer.failure:
        raise InputError(f'{out}: {writer.failure}')


def _temperature_rows(table: LogTable) -> set[int]:
    """Return the rows whose temperatures are written: the first one of each period."""
    if 'temperature' not in table.values:
        return set()
    period = (table.t - table.t[0]) // TEMPERATURE_PERIOD
    return set(np.unique(period, return_index=True)[1].tolist())


def _quaternion(vector: np.ndarray) -> np.ndarray:
    """Return the quaternion of a rotation vector."""
    angle = float(np.linalg.norm(vector))
    return quaternion_of(rotation_about(vector / (angle or 1.0), angle))
