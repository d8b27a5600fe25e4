"""The table of node parameters: defaults valid, wrong values refused by name."""

import math

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ur5_ros.config.node_parameters import ControlParameters, SimParameters
from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS, check, complete
from ur5_ros.errors import InputError
from ur5_ros.signals import stamp_of_period

ALL = SIM_PARAMETERS + CONTROL_PARAMETERS
ANYTHING = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5),
    st.lists(st.floats() | st.integers() | st.text(max_size=2) | st.none(), max_size=7))


@pytest.mark.parametrize('table', [SIM_PARAMETERS, CONTROL_PARAMETERS], ids=['sim', 'control'])
def test_every_default_is_valid_described_and_named_once(table):
    values = complete(table, {})
    assert complete(table, values) == values
    assert len({parameter.name for parameter in table}) == len(table)
    assert all(parameter.description.endswith('.') for parameter in table)


@pytest.mark.parametrize('record', [SimParameters, ControlParameters])
def test_a_record_has_a_field_of_the_declared_type_for_every_parameter(record):
    declared = {each.name.replace('.', '_'): type(each.default).__name__
                for each in record.declared}
    fields = {field.name: field.type.__name__ for field in msgspec.structs.fields(record)}
    assert fields == declared  # list[float] is named list
    parameters = record.of({'tf_prefix': 'left_'})
    assert parameters.changed_by_name() == {'tf_prefix': 'left_'}
    assert record.of(parameters.by_name()) == parameters


@given(st.sampled_from(ALL), ANYTHING)
@settings(max_examples=1000, deadline=None)
def test_a_value_comes_back_finite_and_in_range_or_is_refused_by_name(parameter, value):
    try:
        checked = check(parameter, value)
    except InputError as refusal:
        assert str(refusal).startswith(parameter.name)
        assert '\n' not in str(refusal)
        return
    assert type(checked) is type(parameter.default)
    numbers = checked if isinstance(checked, list) else [checked]
    for number in numbers:
        if isinstance(number, float):
            assert math.isfinite(number)
            assert parameter.lower <= number <= parameter.upper


@pytest.mark.fault(27, 28, 29, 30, 32)
@pytest.mark.parametrize(('given_values', 'words'), [
    ({'controlrate': 5}, "unknown parameter 'controlrate'; the nearest are: control_rate, "),
    ({'control_rate': 0}, 'control_rate is 0; give 1 to 10000'),
    ({'control_rate': 0.5}, 'give a whole number'),
    ({'fallback': 'stop'}, 'give one of: brake, gravity_compensation, zero_torque'),
    ({'initial_positions': [0.0] * 5}, 'initial_positions has 5 numbers; give 6'),
    ({'lockstep': 1}, 'give true or false'),
    ({'payload.mass': float('nan')}, 'give a finite number'),
])
def test_a_wrong_value_is_refused_with_the_way_out(given_values, words):
    with pytest.raises(InputError) as refusal:
        complete(SIM_PARAMETERS, given_values)
    assert words in str(refusal.value)


def test_stamps_round_to_the_nearest_nanosecond_and_never_go_back():
    for rate in (1, 3, 7, 125, 500, 999, 1000, 4000, 10000):
        stamps = [stamp_of_period(k, rate) for k in range(1, 3 * rate + 1)]
        assert all(later > earlier for earlier, later in zip(stamps, stamps[1:], strict=False))
        assert stamps[0] > 0
        assert stamps[rate - 1] == 1_000_000_000
        for k in (1, 2, rate - 1 or 1, 3 * rate):
            assert abs(stamps[k - 1] * rate - k * 1_000_000_000) * 2 <= rate
