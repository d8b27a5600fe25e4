"""Lockstep and paced acceptance, on a clock that the test turns."""

import json

import numpy as np
import pytest

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import JOINT_NAMES, stamp_of_period
from ur5_ros.sim.lockstep_gate import command_gate

COMMAND = 'joint_command'
ARRAY = 'forward_effort_controller/commands'
ONE = np.arange(6.0)


class Clock:
    """Steady time that stands until it is moved."""

    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


def gate_of(clock, **given):
    return command_gate(JOINT_NAMES, SimParameters.of(given), clock)


def stamp(k):
    return stamp_of_period(k, 1000)


def answer(gate, k, torque=ONE):
    assert gate.offer(COMMAND, stamp(k), torque) is None
    decision = gate.next()
    assert decision.step
    gate.published(k + 1)
    return decision


def answered_gate(clock, **given):
    """Return a gate whose first state has been answered."""
    gate = gate_of(clock, **given)
    answer(gate, 1)
    return gate


def test_time_stands_still_until_the_answer_comes(clock):
    gate = gate_of(clock)
    assert not gate.next().step
    decision = answer(gate, 1)
    np.testing.assert_array_equal(decision.command, ONE)
    assert not gate.next().step


@pytest.mark.fault(12)
def test_no_timeout_before_the_first_command_and_copies_go_out_at_ten_hertz(clock):
    gate = gate_of(clock, lockstep_timeout=1.0)
    sent = []
    for _ in range(1000):
        clock.now += 0.01
        decision = gate.next()
        assert not decision.step
        if decision.resend:
            sent.append(clock.now)
    assert 95 <= len(sent) <= 100
    assert gate.fired == 0


def test_no_copies_after_the_first_command(clock):
    gate = answered_gate(clock)
    clock.now += 5.0
    assert not gate.next().resend


@pytest.mark.fault(9)
@pytest.mark.parametrize(('wrong', 'reason'), [
    (stamp(1), 'earlier'), (stamp(3), 'not yet published'), (stamp(2) + 1, 'not yet published'),
])
def test_a_stamp_of_another_state_is_refused_and_counted(clock, wrong, reason):
    gate = answered_gate(clock)
    assert reason in gate.offer(COMMAND, wrong, ONE)
    assert not gate.next().step
    assert sum(gate.refused.values()) == 1


@pytest.mark.fault(10, 13)
def test_a_second_answer_to_the_same_state_is_dropped(clock):
    gate = gate_of(clock)
    assert gate.offer(COMMAND, stamp(1), ONE) is None
    assert 'already answered' in gate.offer(COMMAND, stamp(1), 2 * ONE)
    np.testing.assert_array_equal(gate.next().command, ONE)


@pytest.mark.fault(11)
def test_a_silent_controller_hands_over_to_the_fallback_paced_by_the_wall(clock):
    gate = answered_gate(clock, lockstep_timeout=2.0)
    clock.now += 1.999
    assert not gate.next().step
    clock.now += 0.001
    decision = gate.next()
    assert decision.step and decision.command is None
    assert gate.fired == 1 and not gate.repeatable
    steps, begin = 1, clock.now
    for k in range(3, 10_000):
        gate.published(k)
        while not (decision := gate.next()).step:
            clock.now = decision.wake
        assert decision.command is None
        steps += 1
        if clock.now - begin > 1.0:
            break
    assert steps <= 1.01 * 1000 * (clock.now - begin) + 2
    fired = [event for event in gate.drain_events() if event.kind == 'lockstep']
    assert json.loads(fired[0].values['fired']) is True


@pytest.mark.fault(50, 53)
def test_the_command_that_rearms_lockstep_is_not_applied_itself(clock):
    gate = answered_gate(clock, lockstep_timeout=2.0)
    clock.now += 2.0
    assert gate.next().command is None
    gate.published(3)
    clock.now += 1.0
    assert gate.offer(COMMAND, stamp(2), ONE) is None  # a late answer: a stamp of this run
    decision = gate.next()
    assert decision.step and decision.command is None
    gate.published(4)
    clock.now += 0.5
    assert not gate.next().step, 'lockstep is armed again and waits'
    np.testing.assert_array_equal(answer(gate, 4).command, ONE)
    kinds = [json.loads(event.values['active']) for event in gate.drain_events()
             if event.kind == 'lockstep']
    assert kinds == [False, True]
    assert not gate.repeatable


def test_a_stamp_that_no_state_had_does_not_rearm(clock):
    gate = answered_gate(clock, lockstep_timeout=2.0)
    clock.now += 2.0
    gate.next()
    gate.published(3)
    for wrong in (stamp(9), stamp(2) + 1, -5):
        assert gate.offer(COMMAND, wrong, ONE) == 'not a stamp of this run'
    gate.published(4)
    clock.now += 1.0
    assert gate.next().step


def test_a_timeout_of_zero_waits_for_ever(clock):
    gate = answered_gate(clock, lockstep_timeout=0.0)
    clock.now += 1e6
    assert gate.next() == (False, None, False, None)


def test_the_first_unstamped_command_counts_after_fifty_milliseconds_of_silence(clock):
    gate = gate_of(clock)
    for number in range(4):  # answers to copies of state 1
        assert gate.offer(ARRAY, 0, ONE + number) is None
        clock.now += 0.03
        assert not gate.next().step
    clock.now += 0.03
    decision = gate.next()
    assert decision.step
    np.testing.assert_array_equal(decision.command, ONE + 3)
    assert gate.accepted == 1
    assert sum(gate.refused.values()) == 3


def test_then_exactly_one_unstamped_command_counts_per_state(clock):
    gate = gate_of(clock)
    gate.offer(ARRAY, 0, ONE)
    clock.now += 0.06
    assert gate.next().step
    for k in range(2, 6):
        gate.published(k)
        assert not gate.next().step
        assert gate.offer(ARRAY, 0, k * ONE) is None
        assert gate.offer(ARRAY, 0, 0 * ONE) is not None
        np.testing.assert_array_equal(gate.next().command, k * ONE)
    assert gate.refused[ARRAY, 'state already answered'] == 4


def test_no_copy_goes_out_while_a_command_waits_for_silence(clock):
    gate = gate_of(clock)
    clock.now += 0.09
    gate.offer(ARRAY, 0, ONE)
    clock.now += 0.04
    assert not gate.next().resend


def test_a_reset_forgets_pending_commands_and_asks_for_silence_again(clock):
    gate = gate_of(clock)
    gate.offer(ARRAY, 0, ONE)
    clock.now += 0.06
    gate.next()
    gate.published(2)
    gate.offer(ARRAY, 0, ONE)
    gate.was_reset(3)
    assert not gate.next().step
    gate.offer(ARRAY, 0, ONE)
    assert not gate.next().step
    clock.now += 0.06
    assert gate.next().step


def test_a_pause_does_not_run_into_the_timeout(clock):
    gate = answered_gate(clock, lockstep_timeout=1.0)
    clock.now += 60.0
    gate.resumed()
    assert not gate.next().step
    assert gate.fired == 0


@pytest.mark.fault(1, 2, 5, 6, 7)
@pytest.mark.parametrize(('names', 'effort', 'reason'), [
    (JOINT_NAMES[:5], [0.0] * 5, 'missing joint name'),
    ([], [0.0] * 6, 'missing joint name'),
    ((*JOINT_NAMES[:5], 'wrist_4_joint'), [0.0] * 6, 'unknown joint name'),
    ((*JOINT_NAMES[:5], 'elbow_joint'), [0.0] * 6, 'doubled joint name'),
    ((*JOINT_NAMES, 'elbow_joint'), [0.0] * 7, 'doubled joint name'),
    (JOINT_NAMES, [0.0] * 5, 'wrong number of torques'),
    (JOINT_NAMES[::-1], [0.0] * 7, 'wrong number of torques'),
    (JOINT_NAMES, [0.0] * 5 + [np.nan], 'torque not finite'),
    (JOINT_NAMES, [np.inf] + [0.0] * 5, 'torque not finite'),
])
def test_a_malformed_command_is_refused_whole_with_its_reason(clock, names, effort, reason):
    gate = gate_of(clock)
    assert gate.offer_by_name(COMMAND, stamp(1), names, effort) == reason
    assert not gate.next().step
    assert gate.refused == {(COMMAND, reason): 1}
    refused, = gate.drain_events()
    assert json.loads(refused.values['reason']) == reason


@pytest.mark.fault(6)
def test_names_in_any_order_mean_the_same_torque(clock):
    gate = gate_of(clock)
    order = np.random.default_rng(1).permutation(6)
    names = [JOINT_NAMES[i] for i in order]
    assert gate.offer_by_name(COMMAND, stamp(1), names, ONE[order]) is None
    np.testing.assert_array_equal(gate.next().command, ONE)


@pytest.mark.fault(17)
def test_a_flood_of_refusals_is_counted_in_full_and_reported_once_a_second(clock):
    gate = gate_of(clock)
    for _ in range(3000):
        gate.offer(COMMAND, stamp(7), ONE)
        clock.now += 0.001
    assert sum(gate.refused.values()) == 3000
    assert 3 <= len(gate.drain_events()) <= 4


@pytest.mark.fault(13)
def test_two_publishers_are_reported_by_name_once_and_end_the_claim_of_repeatability(clock):
    gate = gate_of(clock)
    gate.publishers({COMMAND: ['/ur5_control'], ARRAY: []})
    assert gate.repeatable and not gate.drain_events()
    for _ in range(3):
        gate.publishers({COMMAND: ['/ur5_control', '/intruder'], ARRAY: []})
    reported, = gate.drain_events()
    assert '/intruder' in reported.message and '/ur5_control' in reported.message
    assert not gate.repeatable


@pytest.mark.fault(11)
def test_paced_the_newest_command_holds_until_it_is_too_old(clock):
    gate = gate_of(clock, lockstep=False, command_timeout=0.004)
    k, acted = 1, []
    gate.offer(COMMAND, stamp(1), ONE)
    while k < 12:
        decision = gate.next()
        if not decision.step:
            clock.now = decision.wake
            continue
        acted.append(decision.command is not None)
        k += 1
        gate.published(k)
    assert acted == [True] * 5 + [False] * 6, 'ages 0 to 4 ms act, then the fallback'
    assert gate.offer(COMMAND, stamp(12), ONE) is None
    clock.now += 1.0
    assert gate.next().command is not None, 'the fallback does not latch'


@pytest.mark.fault(9, 10)
def test_paced_acceptance_is_a_window_of_simulated_time(clock):
    gate = gate_of(clock, lockstep=False)
    gate.published(100)
    assert gate.offer(COMMAND, stamp(59), ONE) == 'older than command_timeout'
    assert gate.offer(COMMAND, stamp(101), ONE) == 'stamp of a state not yet published'
    assert gate.offer(COMMAND, stamp(60), ONE) is None
    assert gate.offer(COMMAND, stamp(100), ONE) is None
    assert gate.offer(COMMAND, stamp(99), ONE) == 'older than the command that acts'
    assert gate.offer(ARRAY, 0, ONE) is None


@pytest.mark.fault(12)
def test_paced_before_any_command_the_fallback_acts(clock):
    gate = gate_of(clock, lockstep=False)
    clock.now += 1.0
    decision = gate.next()
    assert decision.step and decision.command is None


def test_as_fast_as_it_goes_never_waits(clock):
    gate = gate_of(clock, lockstep=False, realtime_factor=0.0)
    for k in range(2, 100):
        assert gate.next().step
        gate.published(k)
    assert gate.pacer.late == 0


@pytest.mark.parametrize('factor', [0.5, 1.0, 4.0])
def test_paced_periods_follow_the_wall_without_drift(clock, factor):
    gate = gate_of(clock, lockstep=False, realtime_factor=factor)
    begin, k = clock.now, 1
    while k <= 2000:
        decision = gate.next()
        if decision.step:
            k += 1
            gate.published(k)
        else:
            clock.now = decision.wake + 1e-4  # every wake is a little late
    assert clock.now - begin == pytest.approx(2.0 / factor, abs=2e-4)


@pytest.mark.fault(58)
def test_late_periods_are_counted_and_a_long_stop_is_not_made_up_for(clock):
    gate = gate_of(clock, lockstep=False)
    clock.now += 5.0
    assert gate.next().step
    gate.published(2)
    assert not gate.next().step, 'no burst of periods after a stop'
    assert gate.pacer.late == 1
    assert gate.pacer.worst == pytest.approx(5.0 - 0.001)
    assert gate.pacer.lost == pytest.approx(5.0 - 0.001)
