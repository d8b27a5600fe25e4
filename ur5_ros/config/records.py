"""Records: what a file says as a msgspec structure, refused in one line where it is wrong."""

import math
import re
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from ur5_ros.errors import InputError

__all__ = ['Meta', 'Record', 'Six', 'Three', 'as_data', 'validate']

#: msgspec's words, and what a person would say.
_WORDS = {'object': 'keys with values', 'array': 'a list', 'float': 'a finite number',
          'int': 'a whole number', 'str': 'a text', 'bool': 'true or false', 'null': 'nothing',
          'matching regex': 'of the form'}
#: A step of the place that msgspec names: a key, an index, or ``[...]`` for any key of a dict.
_STEP = re.compile(r'\.([^.\[]+)|\[(\d+|\.\.\.)\]')

Path = list[str | int]

#: A number for each joint, or for each axis.
Six = Annotated[list[float], Meta(min_length=6, max_length=6)]
Three = Annotated[list[float], Meta(min_length=3, max_length=3)]


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of what files say: the attributes are the keys, and there are no others."""


Some = TypeVar('Some', bound=msgspec.Struct)


def validate(schema: type[Some], data: Any, source: str) -> Some:
    """
    Return ``data`` as a record of ``schema``.

    Parameters
    ----------
    schema : type
        A :class:`Record`.
    data : Any
        What YAML or JSON gives; every number in it has to be finite.
    source : str
        What to call it in messages.

    Raises
    ------
    InputError
        Naming the first key that is missing, unknown or out of range, and what to give.

    """
    path = _not_finite(data)
    text = 'Expected `float`'
    if path is None:
        try:
            return msgspec.convert(data, schema)
        except msgspec.ValidationError as error:
            text, path = _located(error, schema, data)
    given = _at(data, path)
    if found := re.search(r'(unknown|missing required) field `(.*)`', text, re.DOTALL):
        path = [*path, found[2]]
    place = '.'.join(map(str, path)) or 'the document'
    raise InputError(f'{source}: {place if place.isprintable() else repr(place)}: '
                     f'{_sentence(text, schema, given, path)}')


def as_data(record: Any) -> Any:
    """Return a record, or lists and dicts of records, as plain data under the keys of its file."""
    return msgspec.to_builtins(record)


def _not_finite(data: Any) -> Path | None:
    """Return where a number stands that is not finite, None where there is none."""
    if isinstance(data, float) and not math.isfinite(data):
        return []
    items = data.items() if isinstance(data, dict) else (
        enumerate(data) if isinstance(data, list) else ())
    for step, value in items:
        inside = _not_finite(value)
        if inside is not None:
            return [step, *inside]
    return None


def _located(error: Exception, schema: type, data: Any) -> tuple[str, Path]:
    """Return what msgspec found, and where; the keys of dicts, which it leaves out, are tried."""
    text, _, place = str(error).rpartition(' - at ')
    text, path = text or str(error), Path()
    for key, number in _STEP.findall(place.rstrip('`')):
        if number != '...':
            path.append(key or int(number))
            continue
        for name, value in _at(data, path).items():
            alone = _replaced(data, path, {name: value})
            try:
                msgspec.convert(alone, schema)
            except msgspec.ValidationError:
                path, data = [*path, name], alone
                break
    return text, path


def _at(data: Any, path: Path) -> Any:
    for step in path:
        data = data[step]
    return data


def _replaced(data: Any, path: Path, value: Any) -> Any:
    """Return a copy of the data with another value at a place."""
    if not path:
        return value
    copy = data.copy()
    copy[path[0]] = _replaced(data[path[0]], path[1:], value)
    return copy


def _sentence(text: str, schema: type, given: Any, path: Path) -> str:
    """Return what to give instead, and what was given."""
    if 'missing required field' in text:
        return 'is missing'
    kind: Any = msgspec.inspect.type_info(schema)
    for step in path[:-1] if 'unknown field' in text else path:
        kind = _inside(kind, step)
    if 'unknown field' in text:
        names = [field.encode_name for each in getattr(kind, 'types', (kind,))
                 for field in getattr(each, 'fields', ())]
        return f'unknown key; there are: {", ".join(names)}'
    if ' of length ' in text and getattr(kind, 'min_length', None) == kind.max_length:
        return f'give {kind.max_length} values (given: {str(given)[:60]!r})'
    if 'enum value' in text:
        names = getattr(getattr(kind, 'key_type', kind), 'values', [])
        return f'give one of: {", ".join(map(str, names))} ({text[8:]})'
    wish = text.partition(', got ')[0].removeprefix('Expected ').replace('`', '')
    wish = wish.replace(' | ', ' or ').replace('array of length', 'array with')
    for word, instead in _WORDS.items():
        wish = re.sub(rf'\b{word}\b', instead, wish)
    return f'give {wish} (given: {str(given)[:60]!r})'


def _inside(kind: Any, step: str | int) -> Any:
    """Return the type of what stands under a key or an index."""
    for each in getattr(kind, 'types', (kind,)):
        for field in getattr(each, 'fields', ()):
            if field.encode_name == step:
                return field.type
        inner = getattr(each, 'item_type' if isinstance(step, int) else 'value_type', None)
        if inner is not None:
            return inner
    return None
