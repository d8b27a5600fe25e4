"""The rate is known or not known; it is never a wrong one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5_ros.control.control_rate import AGREEING_STATES, ControlRate
from ur5_ros.errors import InputError
from ur5_ros.signals import stamp_of_period

RATES = st.integers(10, 4000)


@st.composite
def runs(draw):
    """Return runs of simulators one after the other: rate, states heard, when the rate is told."""
    found = []
    for _ in range(draw(st.integers(1, 4))):
        first = draw(st.integers(1, 100_000))
        # states may be lost, but not all neighbours of any
        steps = draw(st.lists(st.sampled_from([1, 1, 1, 2, 3, 40]), max_size=3 * AGREEING_STATES))
        found.append((draw(RATES), first, steps, draw(st.integers(-1, 5))))
    return found


@given(runs(), st.booleans())
def test_a_rate_that_is_known_is_that_of_the_running_simulator(runs, report_comes_first):
    """Whenever one joins, whatever is lost, however often the simulator starts again."""
    known = ControlRate()
    for rate, first, steps, reported_at in runs:
        if report_comes_first and reported_at >= 0:
            known.report(float(rate))
            known.begin_run(keep_report=True)
            assert known.value == rate
        else:
            known.begin_run()
            assert known.value is None
        k, window = first, []
        known.observe(stamp_of_period(k, rate))
        for number, step in enumerate(steps):
            if number == reported_at:
                known.report(float(rate))
            k += step
            window = [*window, step][-AGREEING_STATES + 1:]
            known.observe(stamp_of_period(k, rate))
            if known.source == 'stamps':
                # of a source that is only ever heard every other period, no stamp says so
                assert known.value == rate or 1 not in window
            elif known.source == 'simulator':
                assert known.value == rate
            else:
                assert number < reported_at or reported_at < 0


@given(RATES, st.integers(1, 10**6))
def test_stamps_of_states_in_a_row_are_enough(rate, first):
    known = ControlRate()
    for k in range(first, first + AGREEING_STATES):
        assert known.value is None
        known.observe(stamp_of_period(k, rate))
    assert (known.value, known.source) == (rate, 'stamps')


@pytest.mark.parametrize(('rate', 'taken_for'), [(1000, 1), (1000, 25), (250, 2)])
def test_one_stamp_is_never_enough(rate, taken_for):
    """State k of a fast simulator has the stamp of state 1 of a slow one."""
    known = ControlRate()
    k = rate // taken_for
    known.observe(stamp_of_period(k, rate))
    assert stamp_of_period(k, rate) == stamp_of_period(1, taken_for)
    assert known.value is None


def test_stamps_of_a_wall_clock_agree_on_nothing():
    known = ControlRate()
    for k in range(100):
        known.observe(10**18 + k * 2_000_000 + (k * 7919) % 1000)
    assert known.value is None


def test_the_simulator_counts_before_the_parameter_and_the_parameter_before_the_stamps():
    known = ControlRate(500)
    for k in range(1, 2 * AGREEING_STATES):
        known.observe(stamp_of_period(k, 125))
    assert (known.value, known.source) == (500, 'parameter')
    known.report(125.0)
    assert (known.value, known.source) == (125, 'simulator')


@pytest.mark.parametrize('rate', [0.0, -1.0, 0.5, 62.5, 1e5, float('nan'), float('inf')])
def test_a_rate_that_no_simulator_has_is_refused(rate):
    with pytest.raises(InputError, match='control rate'):
        ControlRate().report(rate)
