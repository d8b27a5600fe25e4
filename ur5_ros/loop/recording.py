"""The two bags of a closed loop without ROS: topics and payloads as the nodes write them."""

import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.bag.cdr import FixedJointState, FixedTrajectoryPoint, encode_clock, encode_string
from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.bag.status import status_array
from ur5_ros.bag.writer import BagWriter
from ur5_ros.config import arm_text, load_arm
from ur5_ros.control.controller import Answer
from ur5_ros.loop.plan import Plan
from ur5_ros.signals import JOINT_NAMES, ArmState, Torque
from ur5_ros.sim.events import Event
from ur5_ros.sim.urdf import urdf_text


class _Topic(NamedTuple):
    name: str
    type: str
    reliability: str = 'reliable'
    durability: str = 'volatile'
    depth: int = 1


_SIM = {
    'joint_states': _Topic('/joint_states', 'sensor_msgs/msg/JointState'),
    'clock': _Topic('/clock', 'rosgraph_msgs/msg/Clock', 'best_effort'),
    'ground_truth': _Topic('/ur5_sim/ground_truth', 'sensor_msgs/msg/JointState'),
    'events': _Topic('/ur5_sim/events', 'diagnostic_msgs/msg/DiagnosticArray', depth=100),
    'run': _Topic('/ur5_sim/run', 'std_msgs/msg/String', durability='transient_local'),
    'robot_description': _Topic('/robot_description', 'std_msgs/msg/String',
                                durability='transient_local'),
    'joint_command': _Topic('/joint_command', 'sensor_msgs/msg/JointState', 'best_effort',
                            depth=10),
}
_CONTROL = {
    'joint_states': _Topic('/joint_states', 'sensor_msgs/msg/JointState', 'best_effort',
                           depth=10),
    'joint_command': _Topic('/joint_command', 'sensor_msgs/msg/JointState'),
    'reference': _Topic('/ur5_control/reference', 'trajectory_msgs/msg/JointTrajectory'),
    'torque_parts': _Topic('/ur5_control/torque_parts', 'sensor_msgs/msg/JointState'),
}


class LoopRecording:
    """
    Both bags of a run while it goes on.

    Parameters
    ----------
    plan : Plan
        Parameters of both sides.
    folder : Path
        Run folder; ``sim`` and ``control`` in it must not exist.

    Raises
    ------
    Refusal
        If a bag exists or cannot be made.

    """

    def __init__(self, plan: Plan, folder: Path) -> None:
        prefix = plan.sim['tf_prefix']
        names = [prefix + name for name in JOINT_NAMES]
        self._state = FixedJointState(names)
        self._command = FixedJointState(names, fields=('effort',))
        self._reference = FixedTrajectoryPoint(names)
        self._parts = FixedJointState(
            [f'{part}/{name}' for part in Torque._fields for name in names], fields=('effort',))
        self._hashes = {'joint_states': PayloadHash(self._state),
                        'joint_command': PayloadHash(self._command)}
        self._exact = not (plan.sim['noise.position'] or plan.sim['noise.velocity']
                           or plan.sim['delay.state_periods'])
        self._arm_name = plan.sim['arm']
        run = folder.name
        self._sim = _Bag('sim', run, folder, plan.sim, _SIM)
        self._control = _Bag('control', run, folder, plan.control, _CONTROL)
        self._sim.write('run', encode_string(run))
        self._sim.write('robot_description',
                        encode_string(urdf_text(load_arm(plan.sim['arm']), prefix)))
        self._periods = 0

    def period(self, state: ArmState, truth: ArmState, answer: Answer) -> None:
        """Record a state and the answer to it."""
        data = self._write_state(state, truth)
        control = self._control
        control.write('joint_states', data)
        stamp, torque, reference = state.stamp, answer.torque, answer.reference
        data = self._command.encode(stamp, (), (), torque.total)
        self._sim.write('joint_command', data)
        control.write('joint_command', data)
        self._hashes['joint_command'].add(data)
        control.write('reference', self._reference.encode(
            stamp, *reference, torque.total - torque.feedback))
        control.write('torque_parts', self._parts.encode(stamp, (), (), np.concatenate(torque)))

    def last_state(self, state: ArmState, truth: ArmState) -> None:
        """Record the state that nobody answers any more."""
        self._control.write('joint_states', self._write_state(state, truth))

    def event(self, event: Event) -> None:
        """Record an event of the plant."""
        self._sim.write('events', status_array(event.stamp, event.kind, event.message,
                                               self._arm_name, event.values))

    def close(self) -> None:
        """Write the summaries and end both bags."""
        summary = {
            'hashes': {name: found.hexdigest() for name, found in self._hashes.items()},
            'periods': self._periods, 'lockstep_fired': False, 'publishers_conflict': False,
            'reason': 'the end of the loop',
        }
        self._sim.close(summary)
        self._control.close(summary)

    def _write_state(self, state: ArmState, truth: ArmState) -> bytes:
        data = self._state.encode(*state)
        self._sim.write('clock', encode_clock(state.stamp))
        self._sim.write('joint_states', data)
        if not self._exact:
            self._sim.write('ground_truth', self._state.encode(*truth))
        self._hashes['joint_states'].add(data)
        self._periods += 1
        return data


class _Bag:
    """One side's bag, its topics by role."""

    def __init__(self, node: str, run: str, folder: Path, parameters: dict[str, Any],
                 topics: dict[str, _Topic]) -> None:
        self._writer = BagWriter(folder / node, describe(
            node, run, parameters['arm'], arm_text(parameters['arm']), parameters,
            {role: topic.name for role, topic in topics.items()}, fingerprint()))
        self._ids = {
            role: self._writer.topic(topic.name, topic.type, qos_profile(
                reliability=topic.reliability, durability=topic.durability, depth=topic.depth))
            for role, topic in topics.items()}
        self._offset = time.time_ns() - time.monotonic_ns()  # the wall clock may jump

    def write(self, role: str, data: bytes) -> None:
        self._writer.write(self._ids[role], time.monotonic_ns() + self._offset, data)

    def close(self, summary: dict[str, Any]) -> None:
        self._writer.note('summary', summary)
        self._writer.close()
