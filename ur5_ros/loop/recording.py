"""The two bags of a closed loop without ROS: topics and payloads as the nodes write them."""

import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.diagnostics import status_array
from ur5_ros.cdr.fixed_messages import (
    FixedJointState,
    FixedPose,
    FixedTrajectoryPoint,
    encode_clock,
    encode_number,
    encode_string,
)
from ur5_ros.config import arm_text
from ur5_ros.config.node_parameters import NodeParameters
from ur5_ros.config.topics import (
    CONTROL_NODE,
    CONTROL_TOPICS,
    SIM_NODE,
    SIM_TOPICS,
    WORLD_TOPICS,
    Topic,
)
from ur5_ros.config.worlds import EMPTY, world_from, world_text
from ur5_ros.control.kernel import FEEDBACK, TOTAL
from ur5_ros.loop.loop_run import LoopRun
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.signals import JOINT_NAMES, ArmState, Reference, Torque
from ur5_ros.sim.events import Event
from ur5_ros.sim.urdf import urdf_text

_NODES = {'sim': SIM_NODE, 'control': CONTROL_NODE}
_TOPICS = {'sim': SIM_TOPICS, 'control': CONTROL_TOPICS}


def record(run: LoopRun, folder: Path) -> None:
    """
    Write both bags of a run that is over.

    ``folder``: run folder; ``sim`` and ``control`` in it must not exist.
    """
    bags = _Bags(run, folder)
    events = defaultdict(list)
    for event in run.events:
        events[event.stamp].append(event)
    truth = run.truth or (run.q, run.qd, run.effort)
    rows = zip(run.stamp.tolist(), run.q, run.qd, run.effort, *truth, run.torque,
               *run.reference, strict=True)
    reports = run.reports or ([],) * len(run.stamp)
    for k, (stamp, q, qd, effort, *exact, torque, q_star, qd_star, qdd_star) in enumerate(rows, 1):
        bags.period(ArmState(stamp, q, qd, effort), ArmState(stamp, *exact), torque,
                    Reference(q_star, qd_star, qdd_star), acts=k < len(run.stamp))
        bags.contact(reports[k - 1])
        for event in events.pop(stamp, ()):
            bags.event(event)
    bags.close('stop_after')


class _Bags:
    """Both bags of a run."""

    def __init__(self, run: LoopRun, folder: Path) -> None:
        config, sim_arm, self._arm = run.config, run.sim_arm, run.control_arm
        prefix = config.sim.tf_prefix
        names = [prefix + name for name in JOINT_NAMES]
        self._state = FixedJointState(names)
        self._command = FixedJointState(names, fields=('effort',))
        self._reference = FixedTrajectoryPoint(names)
        self._parts = FixedJointState(
            [f'{part}/{name}' for part in Torque._fields for name in names], fields=('effort',))
        self._error = FixedJointState(names, fields=('position', 'velocity'))
        self._pose = FixedPose(prefix + 'base')
        self._exact = run.truth is None
        self._arm_name = sim_arm.name
        rate = config.control.monitor_rate
        self._monitor_period, self._monitored = round(1e9 / rate) if rate else 0, -1
        name = folder.name
        world = world_from(config.sim)
        self._sim = _Bag('sim', name, folder, config.sim, sim_arm.name, self._state,
                         self._command, () if world.empty else WORLD_TOPICS)
        self._control = _Bag('control', name, folder, config.control, self._arm.name,
                             self._state, self._command)
        for bag in (self._sim, self._control):
            bag.write('control_rate', encode_number(config.sim.control_rate))
            bag.write('run', encode_string(name))
        self._sim.write('robot_description', encode_string(
            urdf_text(sim_arm, prefix, world=world)))

    def period(self, state: ArmState, truth: ArmState, torque: np.ndarray,
               reference: Reference, acts: bool) -> None:
        """Write a state and the answer to it, which acts unless the run is over."""
        stamp = state.stamp
        sim, control = self._sim, self._control
        data = self._state.encode(*state)
        sim.write('clock', encode_clock(stamp))
        sim.hashed('joint_states', data)
        if not self._exact:
            sim.write('ground_truth', self._state.encode(*truth))
        control.hashed('joint_states', data)
        data = self._command.encode(stamp, (), (), torque[TOTAL])
        if acts:
            sim.hashed('joint_command', data)
        control.hashed('joint_command', data)
        control.write('reference', self._reference.encode(
            stamp, *reference, torque[TOTAL] - torque[FEEDBACK]))
        control.write('torque_parts', self._parts.encode(stamp, (), (), torque.ravel()))
        if self._monitor_period and stamp // self._monitor_period != self._monitored:
            self._monitored = stamp // self._monitor_period
            self._monitor(state, reference)

    def contact(self, messages: list[tuple[str, bytes]]) -> None:
        for role, data in messages:
            self._sim.write(role, data)

    def event(self, event: Event) -> None:
        self._sim.write('events', status_array(event.stamp, event.kind, event.message,
                                               self._arm_name, event.values))

    def close(self, reason: str) -> None:
        self._sim.close(reason)
        self._control.close(reason)

    def _monitor(self, state: ArmState, reference: Reference) -> None:
        q = np.stack([state.q, reference.q]) + self._arm.angle_offset
        tool, desired = forward_kinematics(q, self._arm)
        write = self._control.write
        write('error', self._error.encode(state.stamp, state.q - reference.q,
                                          state.qd - reference.qd))
        write('tool_pose', self._pose.encode(state.stamp, *position_and_quaternion(tool)))
        write('reference_pose', self._pose.encode(state.stamp, *position_and_quaternion(desired)))


class _Bag:
    """One side's bag, its topics by role."""

    def __init__(self, node: str, run: str, folder: Path, parameters: NodeParameters,
                 arm_name: str, state: FixedJointState, command: FixedJointState,
                 more: Sequence[Topic] = ()) -> None:
        self._run = run
        topics = [(topic, topic.absolute(_NODES[node])) for topic in (*_TOPICS[node], *more)]
        self._hashes = {'joint_states': PayloadHash(state), 'joint_command': PayloadHash(command)}
        self._writer = BagWriter(folder / node, describe(
            node, run, arm_name, arm_text(parameters.arm), parameters.by_name(),
            {topic.role: name for topic, name in topics}, fingerprint(),
            world_text(getattr(parameters, 'world', EMPTY))), blocking=True)
        self._ids = {
            topic.role: self._writer.topic(name, topic.type, qos_profile(**topic.qos._asdict()))
            for topic, name in topics}
        self._offset = time.time_ns() - time.monotonic_ns()  # the wall clock may jump

    def write(self, role: str, data: bytes) -> None:
        self._writer.write(self._ids[role], time.monotonic_ns() + self._offset, data)

    def hashed(self, role: str, data: bytes) -> None:
        self.write(role, data)
        self._hashes[role].add(data)

    def close(self, reason: str) -> None:
        self._writer.note('summary', {
            'reason': reason, 'run': self._run,
            'hashes': {role: found.hexdigest() for role, found in self._hashes.items()},
            'periods': self._hashes['joint_states'].count, 'counters': {}})
        self._writer.close()
