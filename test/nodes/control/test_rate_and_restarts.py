"""Any rate at any pace, joined at any time, either node started again: never at a wrong rate."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from thorough import times

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.parameters import HOME
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.nodes.control import cycle as module
from ur5_ros.nodes.control.cycle import ControlCycle
from ur5_ros.signals import JOINT_NAMES, stamp_of_period

#: Wall time in which a restart has to be followed [s].
LONGEST_TAKEOVER = 1.0
#: Wall time in which a simulator that waits for nobody is answered, by a hold at least [s].
LONGEST_SILENCE = 0.15
#: A simulator reports its rate so often [s].
REPORT_PERIOD = 1.0
LAYOUT = FixedJointState(JOINT_NAMES)

RUNS = st.lists(st.fixed_dictionaries({
    'rate': st.integers(10, 4000),
    # 0: as fast as it goes
    'realtime_factor': st.sampled_from([0.0, 0.02, 0.2, 1.0, 5.0]) | st.floats(0.01, 20.0),
    'lockstep': st.booleans(),
    'first': st.integers(1, 100_000),
    'reported': st.floats(-0.3, 0.9),
    'control_restarts': st.sets(st.integers(0, 30), max_size=2),
    'pause': st.floats(0.4, 3.0),
}), min_size=1, max_size=4)


class Pair:
    """A control cycle under a wall clock that the test turns, and the rates of what it hears."""

    def __init__(self, clock: list[float], **parameters) -> None:
        self.parameters = ControlParameters.of({'monitor_rate': 0.0, **parameters})
        self.clock, self.lines, self.answers = clock, [], []
        self.outputs = SimpleNamespace(
            hash=PayloadHash(LAYOUT), begin_run=lambda: None, command_again=lambda: None,
            answer=lambda stamp, parts, reference: self.answers.append((stamp, parts[0])))
        self.follows_on = False
        self.start()

    def start(self) -> None:
        """Start the controller again: it knows nothing."""
        logger = SimpleNamespace(info=self.lines.append, warning=self.lines.append)
        self.cycle = ControlCycle(
            controller_from_parameters(self.parameters), self.outputs,
            SimpleNamespace(write=lambda *_: None), self.parameters, logger,
            lambda: self.cycle.begin_run())

    def send(self, k: int, rate: int) -> bool:
        """Send a state; return whether it was answered, at the rate of its simulator or held."""
        stamp = stamp_of_period(k, rate)
        self.cycle.take(1, LAYOUT.encode(stamp, np.array(HOME), np.zeros(6), np.zeros(6)))
        answered = bool(self.answers) and self.answers[-1][0] == stamp
        # the first stamps of a new simulator may follow on the last one of the old: no state says
        # so, and its report may come later
        if answered and not self.follows_on:
            assert self.cycle.controller_rate in (rate, None), 'an answer at a wrong rate'
        return answered

    def run(self, rate, realtime_factor, lockstep, first, reported, control_restarts, pause):
        """Let a simulator start after a pause, and follow it for three seconds of wall time."""
        self.clock[0] += pause
        self.follows_on = 0 < self.cycle.stamp < stamp_of_period(first, rate)
        began, k = self.clock[0], first
        report_at, received_since = began + reported, began
        period = 1.0 / (rate * realtime_factor) if realtime_factor else 1e-4
        for turn in range(60):
            if self.clock[0] >= report_at:
                self.cycle.take_rate(float(rate))
                self.follows_on = False
                report_at = self.clock[0] + REPORT_PERIOD
            if turn in control_restarts:
                self.start()
                self.follows_on = False
                received_since = self.clock[0]
                report_at = min(report_at, received_since + 0.9)
            answered = self.send(k, rate)
            if not lockstep and self.clock[0] - received_since > LONGEST_SILENCE:
                assert answered, 'the arm is not held'
            if self.clock[0] - received_since > LONGEST_TAKEOVER:
                assert answered, 'not followed within a second'
                assert self.cycle.controller_rate == rate
            if answered or not lockstep:
                k += 1
                self.clock[0] += period
            else:
                self.clock[0] += 0.1  # the same state again
            if turn == 30 and not lockstep:  # a second of states is lost, or not looked at
                lost = int(1.1 / period) + 1
                k, self.clock[0] = k + lost, self.clock[0] + lost * period


@pytest.mark.thorough
@settings(max_examples=times(40, 500), deadline=None, suppress_health_check=[
    HealthCheck.function_scoped_fixture])
@given(RUNS)
def test_no_answer_is_at_a_wrong_rate_and_every_restart_is_followed(monkeypatch, runs):
    clock = [1000.0]
    monkeypatch.setattr(module, 'time', SimpleNamespace(monotonic=lambda: clock[0]))
    pair = Pair(clock)
    starts = len(runs) + sum(len(run['control_restarts']) for run in runs)
    for run in runs:
        pair.run(**run)
    assert len(pair.lines) <= 3 * starts, pair.lines


@pytest.mark.parametrize('realtime_factor', [0.05, 0.2, 1.0, 10.0])
@pytest.mark.parametrize('rate', [10, 250, 1000])
def test_a_slow_clock_is_no_slow_simulator(monkeypatch, rate, realtime_factor):
    """In wall time 250 states a second at 0.2 of real time look like 50 a second."""
    clock = [1000.0]
    monkeypatch.setattr(module, 'time', SimpleNamespace(monotonic=lambda: clock[0]))
    pair = Pair(clock)
    for k in range(1, 200):  # nothing reports the rate
        pair.send(k, rate)
        clock[0] += 1.0 / (rate * realtime_factor)
    assert pair.cycle.controller_rate == rate


def test_an_experiment_that_a_later_margin_forbids_is_not_started_and_the_arm_is_held(monkeypatch):
    clock = [1000.0]
    monkeypatch.setattr(module, 'time', SimpleNamespace(monotonic=lambda: clock[0]))
    pair = Pair(clock, experiment='kebria_fig11', autostart=True)
    pair.cycle.take_rate(500.0)
    for k in range(1, 5):
        assert pair.send(k, 500)
        clock[0] += 0.002
    assert pair.cycle.controller.status()['experiment'] == 'kebria_fig11'
    pair.cycle.controller.change({'singularity_margin': 0.9})
    clock[0] += 2.0  # the simulator ends, and another one begins at another rate
    pair.cycle.take_rate(250.0)
    for k in range(1, 5):
        assert pair.send(k, 250)
        clock[0] += 0.004
    assert pair.cycle.controller_rate == 250
    assert sum('singularity_margin is 0.9' in line for line in pair.lines) == 1
    assert pair.cycle.controller.status()['state'] == 'holding'
    pair.cycle.controller.change({'singularity_margin': 0.01})
    clock[0] += 2.0
    pair.cycle.take_rate(500.0)
    for k in range(1, 5):
        assert pair.send(k, 500)
        clock[0] += 0.002
    assert pair.cycle.controller.status()['experiment'] == 'kebria_fig11'
