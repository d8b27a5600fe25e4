"""Records say what is wrong with a file by the name of the key; what is right they keep."""

import pickle
from typing import Annotated, Literal

import msgspec
import pytest

from ur5_ros.config.records import Meta, Record, as_data, validate
from ur5_ros.config.strict_yaml import parse_yaml
from ur5_ros.errors import InputError


class Wheel(Record, kw_only=True):
    """A part."""

    radius: Annotated[float, Meta(gt=0.0, le=1.0)]
    side: Literal['left', 'right'] = 'left'


class Cart(Record, kw_only=True):
    """Every type that there is."""

    name: Annotated[str, Meta(pattern='^[a-z]+$')]
    wheels: Annotated[list[Wheel], Meta(min_length=1, max_length=2)]
    number: Annotated[int, Meta(ge=0)] = 3
    braked: bool = False
    load: float | None = None
    notes: dict[Literal['x', 'y'], list[float]] = {}
    any: bool | int | float | str | list[float] = ''
    first: float | None = msgspec.field(name='from', default=None)
    axle: list[float] | Wheel = []


WHEEL = {'radius': 0.5}
CART = {'name': 'cart', 'wheels': [WHEEL]}


def test_a_record_is_written_as_it_was_read():
    given = CART | {
        'wheels': [{'radius': 0.5, 'side': 'right'}], 'number': 4, 'braked': True, 'load': 2.5,
        'notes': {'x': [1.0, 2.0]}, 'any': [1.0], 'from': 0.25,
        'axle': {'radius': 0.1, 'side': 'left'}}
    cart = validate(Cart, given, 'cart.yaml')
    assert as_data(cart) == given
    assert as_data(pickle.loads(pickle.dumps(cart))) == given
    assert isinstance(cart.axle, Wheel) and cart.first == 0.25


def test_what_is_left_out_has_its_default_and_nobody_elses():
    one, other = (validate(Cart, CART, 'cart.yaml') for _ in range(2))
    assert (one.number, one.braked, one.load, one.notes, one.axle) == (3, False, None, {}, [])
    one.axle.append(1.0)
    assert other.axle == []


def test_a_record_does_not_change():
    cart = validate(Cart, CART, 'cart.yaml')
    with pytest.raises(AttributeError, match='immutable'):
        cart.name = 'other'


@pytest.mark.parametrize('value', [True, 7, 7.5, 'text', '1e-3', [1.0, 2.0]])
def test_a_value_of_several_types_keeps_its_own(value):
    found = validate(Cart, CART | {'any': value}, 'cart.yaml').any
    assert found == value and type(found) is type(value)


def test_a_whole_number_serves_where_any_number_does():
    assert type(validate(Cart, CART | {'load': 2}, 'cart.yaml').load) is float


@pytest.mark.parametrize('text', ['1e-3', '1E-3', '1.e-3', '.1e-2', '+1.0e-3'])
def test_numbers_with_an_exponent_are_numbers_as_in_yaml_1_2(text):
    assert parse_yaml(f'a: {text}', 'x') == {'a': 1e-3}
    assert parse_yaml(f'a: "{text}"', 'x') == {'a': text}


@pytest.mark.fault(38, 39, 40, 42)
@pytest.mark.parametrize(('change', 'words'), [
    ({'name': 3}, "name: give a text (given: '3')"),
    ({'name': 'A b'}, "name: give a text of the form '^[a-z]+$' (given: 'A b')"),
    ({'name': None}, 'name: give a text'),
    ({'number': -1}, "number: give a whole number >= 0 (given: '-1')"),
    ({'number': 2.5}, 'number: give a whole number'),
    ({'number': True}, 'number: give a whole number'),
    ({'number': '2'}, 'number: give a whole number'),
    ({'braked': 'no'}, 'braked: give true or false'),
    ({'braked': 0}, 'braked: give true or false'),
    ({'load': float('nan')}, 'load: give a finite number'),
    ({'load': float('inf')}, 'load: give a finite number'),
    ({'load': 10**400}, 'load: '),
    ({'load': True}, 'load: give a finite number'),
    ({'load': '2,5'}, "load: give a finite number or nothing (given: '2,5')"),
    ({'wheels': []}, 'wheels: give a list with >= 1'),
    ({'wheels': [WHEEL] * 3}, 'wheels: give a list with <= 2'),
    ({'wheels': 4}, 'wheels: give a list'),
    ({'wheels': [4]}, 'wheels.0: give keys with values'),
    ({'wheels': [WHEEL, {}]}, 'wheels.1.radius: is missing'),
    ({'wheels': [{'radius': 0.0}]}, 'wheels.0.radius: give a finite number > 0'),
    ({'wheels': [{'radius': 1.5}]}, 'wheels.0.radius: give a finite number <= 1'),
    ({'wheels': [WHEEL | {'side': 'up'}]}, 'wheels.0.side: give one of: left, right'),
    ({'wheels': [WHEEL | {'side': []}]}, 'wheels.0.side: give a text'),
    ({'wheels': [WHEEL | {'mass': 1}]}, 'wheels.0.mass: unknown key; there are: radius, side'),
    ({'notes': {'z': []}}, "notes: give one of: x, y (enum value 'z')"),
    ({'notes': {'x': ['one']}}, 'notes.x.0: give a finite number'),
    ({'notes': []}, 'notes: give keys with values'),
    ({'any': {}}, 'any: give true or false or a whole number or a finite number or a text or a'),
    ({'axle': {'radius': 2.0}}, 'axle.radius: give a finite number <= 1'),
    ({'axle': [0.0, 'one']}, 'axle.1: give a finite number'),
    ({'axle': 3}, 'axle: give keys with values or a list'),
    ({'first': 1.0}, 'first: unknown key'),
    ({'a\nb': 1.0}, "'a\\nb': unknown key"),
])
def test_what_is_wrong_is_refused_in_one_line(change, words):
    with pytest.raises(InputError) as refusal:
        validate(Cart, CART | change, 'cart.yaml')
    message = str(refusal.value)
    assert message.startswith('cart.yaml: ') and words in message and '\n' not in message


@pytest.mark.parametrize('data', [None, [], 'text', 3])
def test_what_is_no_mapping_is_no_record(data):
    with pytest.raises(InputError, match='cart.yaml: the document: give keys with values'):
        validate(Cart, data, 'cart.yaml')


def test_a_record_made_by_hand_needs_what_a_file_needs():
    assert Wheel(radius=0.5).side == 'left'
    with pytest.raises(TypeError, match='radius'):
        Wheel()
    with pytest.raises(TypeError, match='mass'):
        Wheel(radius=0.5, mass=1.0)
