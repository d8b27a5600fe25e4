"""From a state's bytes to the command's: every state is answered once, a copy with a copy."""

import time
from collections.abc import Callable
from typing import Any

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.diagnostics import ERROR, OK, STALE, WARN
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.controller import Controller, ControlOutput
from ur5_ros.control.settings import DEFAULT_RATE
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.nodes.control.topics import ControlOutputs
from ur5_ros.nodes.ros.messages import StateReader
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period

#: A robot whose last state came within this wall time has not started again [s].
STATE_TIMEOUT = 0.3


class ControlCycle:
    """
    The controller between two topics.

    Parameters
    ----------
    controller : Controller
        The law and its motions.
    outputs : ControlOutputs
        Where answers go.
    recording : Recording
        The bag.
    parameters : ControlParameters
        Of the node.
    logger
        The node's logger.
    on_restart : callable
        Is called before the first state of a robot that started again; calls :meth:`begin_run`.

    """

    def __init__(
        self, controller: Controller, outputs: ControlOutputs, recording: Recording,
        parameters: ControlParameters, logger: Any, on_restart: Callable[[], None],
    ) -> None:
        self._on_restart = on_restart
        self.controller = controller
        self.stamp = 0
        """Stamp of the state answered last [ns]."""
        self.first_at = 0.0
        """When the first state of the run came, on the steady clock [s]; 0 = none yet."""
        self._outputs = outputs
        self._recording = recording
        self._logger = logger
        self._reader = StateReader([parameters.tf_prefix + name for name in JOINT_NAMES])
        self.hash = PayloadHash(self._reader.layout)
        self._last = b''
        self._rate: int | None = None
        self._planned_rate = DEFAULT_RATE
        rate = parameters.monitor_rate
        self._monitor_period = round(1e9 / rate) if rate else 0
        self._monitored = -1
        self._last_at = 0.0
        self._copies = 0
        self._missing = False

    def take(self, record: int, data: bytes) -> None:
        """
        Answer a state.

        Parameters
        ----------
        record : int
            Number to record it under.
        data : bytes
            sensor_msgs/JointState.

        Raises
        ------
        InputError
            If it cannot be answered.

        """
        if data == self._last:
            self._copies += 1
            self._outputs.command_again()
            return
        state = self._reader.read(data)
        if state.stamp < self.stamp:
            self._go_back(state.stamp)
        if self._rate is None:
            self._find_rate(state.stamp)
        answer = self.controller.update(state)
        self._outputs.answer(state.stamp, answer.parts, answer.reference)
        self._last, self.stamp = data, state.stamp
        self._recording.write(record, data)
        self.hash.add(data)
        self._last_at = time.monotonic()
        if self._monitor_period and state.stamp // self._monitor_period != self._monitored:
            self._monitored = state.stamp // self._monitor_period
            self._monitor(state, answer)

    def _go_back(self, stamp: int) -> None:
        """Take a clock that went back for a robot that started again, unless the old one lives."""
        if time.monotonic() - self._last_at < STATE_TIMEOUT:
            raise InputError(f'stamp {stamp} ns is before {self.stamp} ns, just answered; '
                             'keep one robot on this topic')
        self._on_restart()

    def begin_run(self) -> None:
        """Forget the run before: the next state is a first one."""
        self.controller = Controller(
            self.controller.arm, self.controller.parameters, self._planned_rate)
        self._rate = None
        self.stamp = 0
        self._last = b''
        self.hash = PayloadHash(self._reader.layout)
        self._outputs.begin_run()
        self.first_at, self._copies = 0.0, 0

    def watch(self) -> None:
        """Log when states stop coming, and when they come again."""
        silent = time.monotonic() - self._last_at if self._last_at else 0.0
        timeout = self.controller.parameters.state_timeout
        if silent > timeout and not self._missing:
            self._missing = True
            self.controller.lose_states()
            self._logger.warning(f'no state for {silent:.1f} s; waiting for states')
        elif silent <= timeout and self._missing:
            self._missing = False
            self._logger.info('states come again')

    def counters(self) -> dict[str, Any]:
        """Return what was counted so far."""
        return {'answers': self._outputs.hash.count, 'copies_answered': self._copies}

    def report(self) -> tuple[int, str, dict[str, Any]]:
        """Return level, word and values for the diagnostics."""
        values = self.controller.status()
        word = values.pop('state')
        level = {'waiting for states': STALE, 'refused': WARN, 'stopped by a limit': ERROR}
        return level.get(word, OK), word, values

    def _find_rate(self, stamp: int) -> None:
        """Take the rate from state 1, whose stamp is one period; plan again if it differs."""
        self.first_at = self.first_at or time.monotonic()
        rate = round(1e9 / stamp) if stamp > 0 else 0
        if not 1 <= rate <= 10_000 or stamp_of_period(1, rate) != stamp:
            return
        self._rate = rate
        if rate != self._planned_rate:
            self._planned_rate = rate
            self.controller = Controller(self.controller.arm, self.controller.parameters, rate)

    def _monitor(self, state: ArmState, answer: ControlOutput) -> None:
        arm = self.controller.arm
        tool, desired = (forward_kinematics(q + arm.angle_offset, arm)
                        for q in (state.q, answer.reference.q))
        self._outputs.monitor(state, answer.reference, position_and_quaternion(tool),
                              position_and_quaternion(desired))
