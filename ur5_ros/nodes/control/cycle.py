"""From a state's bytes to the command's: every state is answered once, a copy with a copy."""

import time
from collections.abc import Callable
from typing import Any

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.diagnostics import ERROR, OK, STALE, WARN
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.control_rate import ControlRate
from ur5_ros.control.controller import Controller, ControlOutput
from ur5_ros.control.settings import DEFAULT_RATE
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.nodes.control.slow_law import SlowLaw
from ur5_ros.nodes.control.topics import ControlOutputs
from ur5_ros.nodes.ros.messages import StateReader
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.signals import JOINT_NAMES, ArmState

#: A robot whose last state came within this wall time has not started again [s].
STATE_TIMEOUT = 0.3
#: A state that waits for its answer waits this wall time for the control rate, and where states go
#: on without one the arm is held after the shorter [s]; the log says so after the longer.
RATE_TIMEOUT, PACED_RATE_TIMEOUT = 0.5, 0.1
#: After a silence the report of a simulator that took the old one's place may come so late [s].
REPORT_TIMEOUT = 1.5


class OtherRobotError(InputError):
    """A state of another robot than this run's: refused, and recorded in no bag of the run."""


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
        self._slow_law = SlowLaw(parameters.law_file, logger.warning)
        self._reader = StateReader([parameters.tf_prefix + name for name in JOINT_NAMES])
        self.hash = PayloadHash(self._reader.layout)
        self._last = b''
        self._rate = ControlRate(parameters.control_rate)
        self.controller_rate: int | None = self._rate.value or DEFAULT_RATE
        """Rate that the controller is made for [Hz]; None = it holds, as the rate is unknown."""
        self._tabled_rate = self.controller_rate
        self._awaits_rate = True
        self._waiting_stamp = 0
        self._logged_wait = False
        self._reported_after = -1
        self._autostart, self._experiment = parameters.autostart, parameters.experiment
        rate = parameters.monitor_rate
        self._monitor_period = round(1e9 / rate) if rate else 0
        self._monitored = -1
        self._last_at = 0.0
        self._silence_ended = 0.0
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
        OtherRobotError
            If its stamp went back while the robot of this run lives.

        """
        if data == self._last:
            self._copies += 1
            self._outputs.command_again()
            return
        state = self._reader.read(data)
        if not self.alive:
            self._silence_ended = time.monotonic()
        if state.stamp < self.stamp:
            self._go_back(state.stamp)
        if self._awaits_rate and not self._may_answer(state.stamp):
            return
        began = time.monotonic()
        answer = self.controller.update(state)
        self._outputs.answer(state.stamp, answer.parts, answer.reference)
        self._last, self.stamp = data, state.stamp
        self._recording.write(record, data)
        self.hash.add(data)
        self._last_at = time.monotonic()
        self._slow_law.answered(self._last_at - began, self.controller_rate or DEFAULT_RATE)
        if self._monitor_period and state.stamp // self._monitor_period != self._monitored:
            self._monitored = state.stamp // self._monitor_period
            self._monitor(state, answer)

    def _go_back(self, stamp: int) -> None:
        """Take a clock that went back for a robot that started again, unless the old one lives."""
        if self.alive:
            raise OtherRobotError(f'stamp {stamp} ns is before {self.stamp} ns, just answered; '
                                  'keep one robot on this topic')
        self._on_restart()

    @property
    def alive(self) -> bool:
        """Whether a state was answered a moment ago: its robot has not started again since."""
        return time.monotonic() - self._last_at < STATE_TIMEOUT

    def begin_run(self) -> None:
        """Forget the run before: the next state is a first one."""
        self._rate.begin_run(keep_report=self._reported_after == self.stamp)
        self._awaits_rate, self._logged_wait, self._reported_after = True, False, -1
        self._make_controller(self._rate.value or self.controller_rate or DEFAULT_RATE)
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
            self._logger.info('states arrive again')

    def counters(self) -> dict[str, Any]:
        """Return what was counted so far."""
        return {'answers': self._outputs.hash.count, 'copies_answered': self._copies}

    def report(self) -> tuple[int, str, dict[str, Any]]:
        """Return level, word and values for the diagnostics."""
        values = self.controller.status()
        word = values.pop('state')
        level = {'waiting for states': STALE, 'refused': WARN, 'stopped by a limit': ERROR}
        return level.get(word, OK), word, values

    def take_rate(self, rate: float) -> None:
        """Take the control rate that the simulator reports [Hz]; InputError if it can be none."""
        settled = time.monotonic() - self._silence_ended > REPORT_TIMEOUT
        if rate != self._rate.value and not self._awaits_rate and self.alive and settled:
            return  # of a second simulator, or of one that has not begun yet
        self._rate.report(rate)
        self._reported_after = self.stamp
        self._awaits_rate = self._awaits_rate or self._rate.value != self.controller_rate

    def _may_answer(self, stamp: int) -> bool:
        """Return whether the rate is known, or was awaited long enough: the arm is then held."""
        now = time.monotonic()
        if not self.first_at:
            self.first_at, self._waiting_stamp = now, stamp
        self._rate.observe(stamp)
        rate, waited = self._rate.value, now - self.first_at
        timeout = RATE_TIMEOUT if stamp == self._waiting_stamp else PACED_RATE_TIMEOUT
        if rate is None and waited < timeout:
            return False
        if rate != self.controller_rate:
            self._make_controller(rate)
            if rate is not None:
                self._logger.info(f'{rate} states a second, by the {self._rate.source}')
        if rate is None and waited >= RATE_TIMEOUT and not self._logged_wait:
            self._logged_wait = True
            self._logger.info('nothing reports the control rate: the arm is held until stamps '
                              'agree; or give control_rate')
        self._awaits_rate = rate is None
        return True

    def _make_controller(self, rate: int | None) -> None:
        """Begin with a controller for a rate [Hz]; without one it only holds the arm."""
        before = self.controller
        parameters = before.parameters.replaced({
            'autostart': self._autostart and rate is not None, 'experiment': self._experiment})
        keep = rate in (None, self._tabled_rate)  # to compute the table takes tens of periods
        try:
            self.controller = Controller(before.arm, parameters, rate,
                                         before.experiment if keep else None)
        except InputError as problem:  # of parameters that were changed since: the arm is held
            parameters = parameters.replaced({'experiment': '', 'autostart': False})
            self.controller = Controller(before.arm, parameters, rate)
            self._logger.warning(f'the experiment is not started: {problem}')
        self._tabled_rate = rate or self._tabled_rate
        self.controller_rate = rate

    def _monitor(self, state: ArmState, answer: ControlOutput) -> None:
        arm = self.controller.arm
        tool, desired = (forward_kinematics(q + arm.angle_offset, arm)
                        for q in (state.q, answer.reference.q))
        self._outputs.monitor(state, answer.reference, position_and_quaternion(tool),
                              position_and_quaternion(desired))
