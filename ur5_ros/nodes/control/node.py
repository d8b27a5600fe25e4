"""The node ``ur5_control``: states in, computed torque out."""

import time
from collections import deque
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node

from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.run_folders import new_run_name
from ur5_ros.cdr.diagnostics import ERROR
from ur5_ros.config import arm_text
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.topics import CONTROL_NODE, CONTROL_TOPICS
from ur5_ros.control.controller import Controller, controller_from_parameters
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics, jacobian, jacobian_rate
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.nodes.control.cycle import ControlCycle, OtherRobotError
from ur5_ros.nodes.control.inputs import ControlInputs
from ur5_ros.nodes.control.services import create_services
from ur5_ros.nodes.control.topics import ControlOutputs
from ur5_ros.nodes.ros.background_executor import LoopRequests, poll_graph
from ur5_ros.nodes.ros.diagnostics import WAITING_PERIOD, EverySecond, network
from ur5_ros.nodes.ros.messages import MOST_RECORDED, read_message
from ur5_ros.nodes.ros.parameters import open_node
from ur5_ros.nodes.ros.process import compiling, end_node, fault
from ur5_ros.nodes.ros.realtime import use_realtime
from ur5_ros.nodes.ros.recording import Recording, refuse_folder, run_of
from ur5_ros.nodes.ros.shutdown import StopRequest
from ur5_ros.nodes.ros.topics import Loop, Topics, incompatible_publishers, make_loop
from ur5_ros.throttle import RefusalCount, Throttle

#: Longest wait before signals, services and the watchdog are looked at [s].
POLL_PERIOD = 0.05
#: Wall time for the results of goals that the end of the node aborts [s].
RESULT_TIMEOUT = 0.3
#: A simulator names its run every second; after this wall time the run is over [s].
NAME_TIMEOUT = 2.5
#: Two robots count when so many looks in a row, a second apart, find the same ones: for two
#: seconds the middleware lists one that was killed.
CROWDED_LOOKS = 4
#: Wall time after the first state in which a run may still be named [s].
NAMING_TIME = 5.0


class ControlNode:
    """The controller on its topics."""

    def __init__(
        self, files: list[Path], stop: StopRequest,
        loop: Callable[[Node, str], Loop] = make_loop, elsewhere: Collection[str] = (),
    ) -> None:
        self.node, self.parameters = open_node(CONTROL_NODE, files, ControlParameters, elsewhere)
        refuse_folder(self.parameters.bag)
        self._logger = self.node.get_logger()
        with compiling(self._logger):  # and planning, before anything is subscribed to
            controller = controller_from_parameters(
                self.parameters, self.parameters.control_rate or None)
            _prepare_kinematics(controller.arm)
        self.recording = Recording(
            self.parameters.bag, 'control', self.parameters.max_bagfile_duration,
            self.parameters.max_bagfile_size)
        self._loop = loop(self.node, self.parameters.hot_loop)
        self.requests = LoopRequests(self._loop.wake)
        topics = self._topics = Topics(self.node, self._loop, self.recording, CONTROL_TOPICS)
        self._names = topics.names
        self.outputs = ControlOutputs(
            self.node, topics, self.recording, self.parameters, controller.arm.name)
        self._refusals, self._last_refusal = RefusalCount(), ''
        self.cycle = ControlCycle(
            controller, self.outputs, self.recording, self.parameters, self._logger,
            self._begin_run)
        self.inputs = ControlInputs(topics, self.recording, self.cycle)
        self._subscriptions: dict[int, tuple[str, int, Any]] = dict(self.inputs.subscriptions)
        for role, take in (('joint_states', self.cycle.take), ('run', self._take_run),
                           ('control_rate', self._take_rate)):
            number, record = topics.subscribe(role)
            self._subscriptions[number] = (topics.names[role], record, take)
        self._run_name, self._named_at = '', 0.0
        self._started_with = controller.parameters
        self._changes: list[dict[str, Any]] = []
        self._robots: deque[set[bytes]] = deque(maxlen=CROWDED_LOOKS)
        self._two_robots = False
        self._reported_rate = 0.0
        self._every_second = EverySecond()
        self._waiting_line = Throttle(WAITING_PERIOD)
        self.trajectories = create_services(self.node, self)
        poll_graph(self.node, self._poll_graph)
        self._loop.start()

    def begin(self) -> None:
        """Log what is waited for."""
        use_realtime(self.parameters.realtime_priority, self._logger)
        self._log_waiting()

    def turn(self) -> bool:
        """Answer the states that come; return whether any message has come."""
        messages = self._loop.wait(POLL_PERIOD)
        for number, data in messages:
            self._dispatch(number, data)
        if self.requests:
            self.requests.serve()
        if self._every_second.due():
            self._report()
        return bool(messages)

    def _dispatch(self, number: int, data: bytes) -> None:
        topic, record, take = self._subscriptions[number]
        try:
            take(record, data)
        except InputError as error:
            self._refuse(topic, 'refused', str(error))
            if len(data) <= MOST_RECORDED and not isinstance(error, OtherRobotError):
                self.recording.write(record, data)
        except Exception as error:  # without an answer the robot brakes; the next state may do
            self._refuse(topic, 'fault', fault(self._logger, error))

    def _refuse(self, topic: str, kind: str, reason: str) -> None:
        """Count what is refused, and log it now and then."""
        self._last_refusal = f'{topic}: {reason}'
        if count := self._refusals.add(topic, kind):
            self._logger.warning(
                f'refused {topic}: {reason}' + (f' ({count} so far)' if count > 1 else ''))

    def prepare(self, changes: dict[str, Any]) -> None:
        """Refuse changes, or compile what they need: a controller of its own tries them."""
        controller = self.cycle.controller
        state, _ = controller.last
        trial = Controller(controller.arm, controller.parameters.replaced(
            {**changes, 'experiment': '', 'autostart': False}), self.cycle.controller_rate)
        if state is not None:
            trial.update(state)

    def change(self, changes: dict[str, Any]) -> None:
        """Change live parameters; they act from the next state, and the bag knows."""
        self.cycle.controller.change(changes)
        self._changes.append({'stamp': self.cycle.stamp, **changes})
        self.recording.note('parameter_changes', {'changes': self._changes})

    def _take_run(self, record: int, data: bytes) -> None:
        name = str(read_message('std_msgs/msg/String', data)['data'])
        now = time.monotonic()
        if name == self._run_name:
            self._named_at = now
            return
        if not name or len(name) > 200 or '/' in name or name.startswith('.'):
            raise InputError(f'{name[:60]!r} names no run; give a word that can name a folder')
        if self._run_name and self.cycle.alive and now - self._named_at < NAME_TIMEOUT:
            return  # of a second simulator, or of one that has not begun yet
        self._named_at = now
        if self._run_name:
            self._begin_run()
        self._open_bag(name)
        self.recording.write(record, data)

    def _take_rate(self, record: int, data: bytes) -> None:
        rate = float(read_message('std_msgs/msg/Float64', data)['data'])
        configured = self.parameters.control_rate
        if configured and rate not in (configured, self._reported_rate):
            self._logger.warning(f'control_rate is {configured} Hz, the simulator reports '
                                 f'{rate:g} Hz, which is used')
        self.cycle.take_rate(rate)
        if rate != self._reported_rate:
            self._reported_rate = rate
            self.recording.write(record, data)

    def _begin_run(self) -> None:
        """Close the run, and let what comes wait for the name of the next."""
        self._logger.info('the robot started again: a new run')
        self._close_bag('a new run began')
        self._run_name = ''
        self._changes = []
        self._started_with = self.cycle.controller.parameters
        self.cycle.begin_run()

    def _open_bag(self, name: str) -> None:
        self._run_name = name
        arm = self.parameters.arm
        self.recording.begin(name, describe(
            'control', name, self.cycle.controller.arm.name, arm_text(arm),
            self._started_with.by_name(), self._names, fingerprint()))
        if self._changes:
            self.recording.note('parameter_changes', {'changes': self._changes})
        if self.recording.folder:
            self._logger.info(f'recording {self.recording.folder}')

    def _close_bag(self, reason: str) -> None:
        self.recording.end({
            'reason': reason, 'run': self._run_name,
            'hashes': {'joint_states': self.cycle.hash.hexdigest(),
                       'joint_command': self.outputs.hash.hexdigest()},
            'periods': self.outputs.hash.count, 'counters': self.counters(),
        })

    def counters(self) -> dict[str, Any]:
        """Return what was counted so far."""
        return {**self.cycle.counters(), **{
            f'{topic}: {kind}': count for (topic, kind), count in self._refusals.counts.items()}}

    def _poll_graph(self) -> None:
        """Look for the publishers of states and for incompatible ones; report them to the loop."""
        found = incompatible_publishers(self.node, self._topics)
        states = self._names['joint_states']
        robots = {bytes(each.endpoint_gid): each.node_name
                  for each in self.node.get_publishers_info_by_topic(states)}
        self._robots.append(set(robots))
        staying = set.intersection(*self._robots)
        crowded = len(self._robots) == CROWDED_LOOKS and len(staying) > 1
        if crowded:
            names = ', '.join(sorted(robots[publisher] for publisher in staying))
            found.append((states, 'two robots', f'published by {names}; keep one of them'))

        def report_found() -> None:
            self._two_robots = crowded
            for sentence in found:
                self._refuse(*sentence)

        self.requests.post(report_found)

    def _report(self) -> None:
        self.cycle.watch()
        if self.recording.failure:
            self._refuse('bag', 'failure', self.recording.failure)
        if not self.cycle.first_at:
            self._log_waiting()
        elif not self._run_name and time.monotonic() - self.cycle.first_at > NAMING_TIME:
            self._open_bag(run_of(self.recording.where, new_run_name))
            self._logger.warning('no simulator named the run; it is called ' + self._run_name)
        level, word, values = self.cycle.report()
        values['last_refusal'] = self._last_refusal or values['last_refusal']
        values |= self.counters() | {'bag_lost': self.recording.lost}
        self.outputs.diagnostics(self.cycle.stamp, ERROR if self._two_robots else level, word,
                                 values)

    def _log_waiting(self) -> None:
        if self._waiting_line('waiting'):
            self._logger.info(f'waiting for states on {self._names["joint_states"]}; '
                              f'{network()}')

    def _end_goals(self) -> None:
        """Go on until open goals of the action have their results, which takes a moment."""
        if self.trajectories is None or self.trajectories.idle:
            return
        self.trajectories.close()
        end = time.monotonic() + RESULT_TIMEOUT
        while time.monotonic() < end:  # the middleware sends the results meanwhile
            if not self.turn():
                time.sleep(0.001)

    def end(self, reason: str) -> int:
        """Close the bag, and return the exit code."""
        self._end_goals()
        self.requests.close()
        self._loop.close()
        if self.recording.where and not self.recording.is_open and self.cycle.first_at:
            self._open_bag(run_of(self.recording.where, new_run_name))
        self._close_bag(reason)
        return end_node(self.node, self.recording, f'ends: {reason}')


def _prepare_kinematics(arm: ArmParameters) -> None:
    """Compile what paths, guards and the monitor need: no state may wait for it."""
    q = np.zeros(6)
    forward_kinematics(q, arm)
    jacobian(q, arm)
    jacobian_rate(q, q, arm)
