"""Recordings as other tools leave them, made of the equations: a healthy motion and its bags."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.fixed_messages import FixedJointState, encode
from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.signals import JOINT_NAMES

JOINT_STATE = 'sensor_msgs/msg/JointState'
STATES = '/joint_states'
#: Torque of a unit of current of a drive [N m/A], by joint.
DRIVE = np.array([13.0, 13.0, 10.0, 9.5, 9.0, 9.0])
START = 1_780_000_000_000_000_000
GRIPPER = ('robotiq_85_left_knuckle_joint',)


@dataclass(frozen=True)
class Motion:
    """Stamps [ns], positions, velocities, efforts; (n, 6) each."""

    stamp: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    effort: np.ndarray

    def with_(self, **parts) -> 'Motion':
        return replace(self, **parts)

    @property
    def t(self):
        return (self.stamp - self.stamp[0]) * 1e-9


def motion(arm='ur5e', n=700, rate=500.0, still=False, friction=0.0) -> Motion:
    """Return a smooth motion of an arm with the torque of its equations."""
    parameters = load_arm(arm) if isinstance(arm, str) else arm
    t = np.arange(n) / rate
    w = np.array([2.1, 1.7, 2.6, 3.1, 3.7, 4.3]) * (0.0 if still else 1.0)
    home = np.array([0.4, -1.5, 1.4, -1.8, -1.2, 0.4])
    phase = np.arange(6) * 0.7
    q = home + 0.3 * np.sin(np.outer(t, w) + phase)
    qd = 0.3 * w * np.cos(np.outer(t, w) + phase)
    qdd = -0.3 * w**2 * np.sin(np.outer(t, w) + phase)
    effort = inverse_dynamics(q + parameters.angle_offset, qd, qdd, parameters)
    effort = effort + friction * np.sign(qd)
    stamp = START + np.rint(t * 1e9).astype(np.int64)
    return Motion(stamp, q, qd, effort)


def gravity(made: Motion, arm='ur5e') -> np.ndarray:
    """Return the gravity torque along a motion."""
    parameters = load_arm(arm)
    return gravity_torque(made.q + parameters.angle_offset, parameters)


def arm_messages(made: Motion, fields=('position', 'velocity', 'effort'), prefix='',
                 frame='') -> list[tuple[int, bytes]]:
    """Return (log time, message) of every state of an arm."""
    codec = FixedJointState([prefix + name for name in JOINT_NAMES], frame, fields)
    values = {'position': made.q, 'velocity': made.qd, 'effort': made.effort}
    return [(int(stamp) + 300_000, codec.encode(int(stamp), *(
        values[name][k] if name in fields else () for name in values)))
        for k, stamp in enumerate(made.stamp)]


def message(stamp: int, name=(), position=(), velocity=(), effort=()) -> bytes:
    """Return any sensor_msgs/JointState."""
    seconds, nanoseconds = divmod(int(stamp), 1_000_000_000)
    return encode(JOINT_STATE, {
        'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds}}, 'name': list(name),
        'position': np.array(position, float), 'velocity': np.array(velocity, float),
        'effort': np.array(effort, float)})


def gripper_messages(made: Motion, every=5) -> list[tuple[int, bytes]]:
    """Return a gripper's joint states between those of an arm."""
    return [(int(stamp) + 250_000, message(stamp + 100_000, GRIPPER, [0.1], [0.0]))
            for stamp in made.stamp[::every]]


def write_bag(folder: Path, topics: dict[str, list[tuple[int, bytes]]],
              types: dict[str, str] | None = None) -> Path:
    """Write messages as a bag without a description, in the order of the log times."""
    rows = sorted(((time, topic, data) for topic, messages in topics.items()
                   for time, data in messages), key=lambda row: row[0])
    with BagWriter(folder, {}, blocking=True) as writer:
        number = {topic: writer.topic(topic, (types or {}).get(topic, JOINT_STATE))
                  for topic in topics}
        for time, topic, data in rows:
            writer.write(number[topic], time, data)
    return folder


def remarks(result) -> str:
    """Return what a result remarks of its recording, in one text."""
    return '; '.join(result.about['remarks'])
