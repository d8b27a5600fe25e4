"""Records: what a file says as a class of annotated keys, each value checked and none guessed."""

import math
import re
from collections.abc import Callable
from copy import copy
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from ur5_ros.errors import Refusal

_ABSENT = object()
_KNOWN: dict[type, dict[str, Any]] = {}


class Rule(NamedTuple):
    """What a value must fulfil beside its type; stands in ``Annotated``."""

    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    shortest: int = 0
    """Fewest values of a list."""
    longest: int | None = None
    pattern: str = ''
    """Regular expression for the whole of a text."""
    key: str = ''
    """Key in the file, where an attribute cannot have its name."""


class Problem(NamedTuple):
    """What is wrong with a file, and where."""

    place: tuple[str, ...]
    wish: str
    given: Any = _ABSENT


class _Key(NamedTuple):
    name: str
    kind: Any
    default: Any


class Record:
    """
    Base of what files say: the annotated attributes are the keys, those without value required.

    Types: bool, int, float (finite), str, None, Literal, list, dict with text keys, other records
    and unions of them, each with a :class:`Rule` if ``Annotated``.  Keys that no attribute stands
    for are refused.

    """

    _ignores_the_rest = False
    """Whether keys that no attribute stands for are left alone."""

    def __init__(self, **values: Any) -> None:
        for attribute, key in _keys(type(self)).items():
            value = values.pop(attribute, key.default)
            if value is _ABSENT:
                raise TypeError(f'{type(self).__name__} needs {attribute}')
            vars(self)[attribute] = value if value is not key.default else copy(value)
        if values:
            raise TypeError(f'{type(self).__name__} has no {", ".join(values)}')

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f'{type(self).__name__}.{name} cannot be changed')

    def __repr__(self) -> str:
        inside = ', '.join(f'{name}={value!r}' for name, value in vars(self).items())
        return f'{type(self).__name__}({inside})'


Some = TypeVar('Some', bound=Record)


def validate(schema: type[Some], data: Any, source: str) -> Some:
    """
    Return ``data`` as a record of ``schema``.

    Parameters
    ----------
    schema : type
        A :class:`Record`.
    data : Any
        What YAML or JSON gives.
    source : str
        What to call it in messages.

    Raises
    ------
    Refusal
        Naming the first key that is missing, unknown or out of range, and how many more.

    """
    problems: list[Problem] = []
    record = _record(schema, data, (), problems, False)
    if not problems:
        return record
    parts, wish, given = problems[0]
    place = '.'.join(parts) or 'the document'
    said = '' if given is _ABSENT else f' (given: {str(given)[:60]!r})'
    more = f'; {len(problems) - 1} more' if len(problems) > 1 else ''
    raise Refusal(f'{source}: {place if place.isprintable() else repr(place)}: {wish}{said}{more}')


def as_data(value: Any) -> Any:
    """Return a record, or lists and dicts of records, as plain data under the keys of its file."""
    if isinstance(value, Record):
        return {key.name: as_data(getattr(value, attribute))
                for attribute, key in _keys(type(value)).items()}
    if isinstance(value, dict):
        return {key: as_data(each) for key, each in value.items()}
    return [as_data(each) for each in value] if isinstance(value, list) else value


def _keys(schema: type[Record]) -> dict[str, _Key]:
    """Return attribute name to key in the file, type and default."""
    if schema in _KNOWN:
        return _KNOWN[schema]
    found = {}
    for attribute, kind in get_type_hints(schema, include_extras=True).items():
        rules = [each for each in getattr(kind, '__metadata__', ()) if isinstance(each, Rule)]
        name = next((rule.key for rule in rules if rule.key), attribute)
        found[attribute] = _Key(name, kind, getattr(schema, attribute, _ABSENT))
    _KNOWN[schema] = found  # when it is whole: other threads look
    return found


def _value(kind: Any, data: Any, place: tuple[str, ...], problems: list[Problem],
           exact: bool) -> Any:
    """Return ``data`` as ``kind``, telling ``problems`` what is wrong; ``exact``: convert none."""
    origin = get_origin(kind)
    if origin is Annotated:
        inner, *rules = get_args(kind)
        before = len(problems)
        value = _value(inner, data, place, problems, exact)
        if len(problems) == before and value is not None:
            problems += [Problem(place, f'give {wish}', data) for rule in rules
                         if (wish := _broken(rule, value))]
        return value
    if origin in (Union, UnionType):
        return _one_of(get_args(kind), data, place, problems)
    if origin is Literal:
        if isinstance(data, str) and data in get_args(kind):
            return data
        wish = f'one of: {", ".join(get_args(kind))}'
    elif origin is list:
        if isinstance(data, list):
            item, = get_args(kind)
            return [_value(item, each, (*place, str(number)), problems, exact)
                    for number, each in enumerate(data)]
        wish = 'a list'
    elif origin is dict:
        if isinstance(data, dict):
            name, item = get_args(kind)
            return {_value(name, key, (*place, str(key)), problems, exact):
                    _value(item, each, (*place, str(key)), problems, exact)
                    for key, each in data.items()}
        wish = 'keys with values'
    elif issubclass(kind, Record):
        return _record(kind, data, place, problems, exact)
    else:
        wish, read = _PLAIN[kind]
        value = read(data, exact)
        if value is not _ABSENT:
            return value
    problems.append(Problem(place, f'give {wish}', data))
    return None


def _record(schema: type[Some], data: Any, place: tuple[str, ...], problems: list[Problem],
            exact: bool) -> Any:
    if not isinstance(data, dict):
        problems.append(Problem(place, 'give keys with values', data))
        return None
    keys, before, values = _keys(schema), len(problems), {}
    names = [key.name for key in keys.values()]
    for attribute, (name, kind, default) in keys.items():
        if name in data:
            values[attribute] = _value(kind, data[name], (*place, name), problems, exact)
        elif default is _ABSENT:
            problems.append(Problem((*place, name), 'is missing'))
    if not schema._ignores_the_rest:
        problems += [Problem((*place, str(name)), f'unknown key; there are: {", ".join(names)}')
                     for name in data if name not in names]
    return schema(**values) if len(problems) == before else None


def _one_of(kinds: tuple[Any, ...], data: Any, place: tuple[str, ...],
            problems: list[Problem]) -> Any:
    """Return ``data`` as the first of the kinds that it is, or can be taken for."""
    for exact in (True, False):
        tried = []
        for kind in kinds:
            trial: list[Problem] = []
            value = _value(kind, data, place, trial, exact)
            if not trial:
                return value
            tried += [trial] if kind is not NoneType else []
    # the kind that was meant is the one whose problems lie deepest
    deepest = max(tried, key=lambda trial: len(trial[0].place))
    if len(tried) > 1 and deepest[0].place == place:
        wishes = ' or '.join(trial[0].wish.removeprefix('give ') for trial in tried)
        deepest = [Problem(place, f'give {wishes}', data)]
    problems += deepest
    return None


def _broken(rule: Rule, value: Any) -> str:
    """Return what a value should be like by a rule that it breaks, '' if it breaks none."""
    if isinstance(value, str):
        return '' if re.fullmatch(rule.pattern or '(?s).*', value) else f'a text of {rule.pattern}'
    if isinstance(value, list):
        if rule.shortest <= len(value) <= (len(value) if rule.longest is None else rule.longest):
            return ''
        if rule.shortest == rule.longest:
            return f'{rule.shortest} values'
        return (f'at least {rule.shortest} values' if len(value) < rule.shortest
                else f'at most {rule.longest} values')
    if rule.above is not None and not value > rule.above:
        return f'more than {rule.above:.12g}'
    if rule.at_least is not None and not value >= rule.at_least:
        return f'at least {rule.at_least:.12g}'
    if rule.at_most is not None and not value <= rule.at_most:
        return f'at most {rule.at_most:.12g}'
    return ''


def _number(data: Any, exact: bool) -> Any:
    """Return a finite float; 1e-3, a text to YAML 1.1, is taken for the number that it is."""
    if isinstance(data, bool) or not isinstance(data, (int, float) if exact else
                                                (int, float, str)):
        return _ABSENT
    try:
        value = float(data)
    except (ValueError, OverflowError):
        return _ABSENT
    return value if math.isfinite(value) else _ABSENT


def _whole(data: Any, exact: bool) -> Any:
    if isinstance(data, float) and data.is_integer() and not exact:
        return int(data)
    return data if isinstance(data, int) and not isinstance(data, bool) else _ABSENT


def _just(kind: type) -> Callable[[Any, bool], Any]:
    return lambda data, _: data if isinstance(data, kind) else _ABSENT


_PLAIN: dict[type, tuple[str, Callable[[Any, bool], Any]]] = {
    bool: ('true or false', _just(bool)),
    int: ('a whole number', _whole),
    float: ('a finite number', _number),
    str: ('a text', _just(str)),
    NoneType: ('nothing', _just(NoneType)),
}
