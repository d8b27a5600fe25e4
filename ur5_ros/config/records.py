"""Records: the content of a file as a msgspec structure, refused in one line if it is wrong."""

import math
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from ur5_ros.errors import InputError, one_line

__all__ = ['Meta', 'Record', 'Six', 'Three', 'as_data', 'validate']

#: A number for each joint, or for each axis.
Six = Annotated[list[float], Meta(min_length=6, max_length=6)]
Three = Annotated[list[float], Meta(min_length=3, max_length=3)]


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of the records of files: the attributes are the keys, and there are no others."""


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
        Naming the first key that is missing, unknown or out of range, and what is expected.

    """
    place = _not_finite(data)
    if place is not None:
        raise InputError(one_line(f'{source}: Expected a finite number - at `${place}`'))
    try:
        return msgspec.convert(data, schema)
    except msgspec.ValidationError as error:
        raise InputError(one_line(f'{source}: {error}')) from None


def as_data(record: Any) -> Any:
    """Return a record, or lists and dicts of records, as plain data under the keys of its file."""
    return msgspec.to_builtins(record)


def _not_finite(data: Any) -> str | None:
    """Return the place of a number that is not finite, written as msgspec does; None without."""
    if isinstance(data, float) and not math.isfinite(data):
        return ''
    items = ([(f'.{key}', value) for key, value in data.items()] if isinstance(data, dict) else
             [(f'[{i}]', value) for i, value in enumerate(data)] if isinstance(data, list) else [])
    for step, value in items:
        inside = _not_finite(value)
        if inside is not None:
            return step + inside
    return None
