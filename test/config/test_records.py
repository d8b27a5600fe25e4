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


def test_what_is_left_out_has_its_own_default():
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
    ({'name': 3}, 'Expected `str`, got `int` - at `$.name`'),
    ({'name': 'A b'}, "Expected `str` matching regex '^[a-z]+$' - at `$.name`"),
    ({'name': None}, 'Expected `str`, got `null` - at `$.name`'),
    ({'number': -1}, 'Expected `int` >= 0 - at `$.number`'),
    ({'number': 2.5}, 'Expected `int`, got `float` - at `$.number`'),
    ({'number': True}, 'Expected `int`, got `bool` - at `$.number`'),
    ({'number': '2'}, 'Expected `int`, got `str` - at `$.number`'),
    ({'braked': 'no'}, 'Expected `bool`, got `str` - at `$.braked`'),
    ({'braked': 0}, 'Expected `bool`, got `int` - at `$.braked`'),
    ({'load': float('nan')}, 'Expected a finite number - at `$.load`'),
    ({'load': float('inf')}, 'Expected a finite number - at `$.load`'),
    ({'notes': {'x': [0.0, float('nan')]}}, 'Expected a finite number - at `$.notes.x[1]`'),
    ({'load': 10**400}, 'Number out of range - at `$.load`'),
    ({'load': True}, 'Expected `float | null`, got `bool` - at `$.load`'),
    ({'load': '2,5'}, 'Expected `float | null`, got `str` - at `$.load`'),
    ({'wheels': []}, 'Expected `array` of length >= 1 - at `$.wheels`'),
    ({'wheels': [WHEEL] * 3}, 'Expected `array` of length <= 2 - at `$.wheels`'),
    ({'wheels': 4}, 'Expected `array`, got `int` - at `$.wheels`'),
    ({'wheels': [4]}, 'Expected `object`, got `int` - at `$.wheels[0]`'),
    ({'wheels': [WHEEL, {}]}, 'Object missing required field `radius` - at `$.wheels[1]`'),
    ({'wheels': [{'radius': 0.0}]}, 'Expected `float` > 0.0 - at `$.wheels[0].radius`'),
    ({'wheels': [{'radius': 1.5}]}, 'Expected `float` <= 1.0 - at `$.wheels[0].radius`'),
    ({'wheels': [WHEEL | {'side': 'up'}]}, "Invalid enum value 'up' - at `$.wheels[0].side`"),
    ({'wheels': [WHEEL | {'side': []}]}, 'Expected `str`, got `array` - at `$.wheels[0].side`'),
    ({'wheels': [WHEEL | {'mass': 1}]}, 'unknown field `mass` - at `$.wheels[0]`'),
    ({'notes': {'z': []}}, "Invalid enum value 'z' - at `key` in `$.notes`"),
    ({'notes': {'x': ['one']}}, 'Expected `float`, got `str` - at `$.notes[...][0]`'),
    ({'notes': []}, 'Expected `object`, got `array` - at `$.notes`'),
    ({'any': {}}, 'Expected `bool | int | float | str | array`, got `object` - at `$.any`'),
    ({'axle': {'radius': 2.0}}, 'Expected `float` <= 1.0 - at `$.axle.radius`'),
    ({'axle': [0.0, 'one']}, 'Expected `float`, got `str` - at `$.axle[1]`'),
    ({'axle': 3}, 'Expected `object | array`, got `int` - at `$.axle`'),
    ({'first': 1.0}, 'unknown field `first`'),
    ({'a\nb': 1.0}, 'unknown field `a?b`'),
])
def test_what_is_wrong_is_refused_in_one_line(change, words):
    with pytest.raises(InputError) as refusal:
        validate(Cart, CART | change, 'cart.yaml')
    message = str(refusal.value)
    assert message.startswith('cart.yaml: ') and words in message and '\n' not in message


@pytest.mark.parametrize('data', [None, [], 'text', 3])
def test_what_is_no_mapping_is_no_record(data):
    with pytest.raises(InputError, match='cart.yaml: Expected `object`, got `'):
        validate(Cart, data, 'cart.yaml')


def test_a_record_made_by_hand_needs_what_a_file_needs():
    assert Wheel(radius=0.5).side == 'left'
    with pytest.raises(TypeError, match='radius'):
        Wheel()
    with pytest.raises(TypeError, match='mass'):
        Wheel(radius=0.5, mass=1.0)
