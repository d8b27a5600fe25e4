"""Any message as CDR bytes and back, by its definition: within bounds, both byte orders."""

from collections.abc import Mapping
from struct import Struct
from struct import error as StructError
from typing import Any

import numpy as np

from ur5_ros.cdr.message_definition import PRIMITIVES, Definition, Field
from ur5_ros.cdr.recorded_types import definition, dependencies
from ur5_ros.errors import BagError

Definitions = Mapping[str, Definition]

#: Deepest nest of types; common_interfaces stays below 6.
MAX_DEPTH = 16


def definitions_of(type_name: str) -> dict[str, Definition]:
    """Return the definitions of a recorded type and all that it is made of."""
    return {name: definition(name) for name in (type_name, *dependencies(type_name))}


def decode(type_name: str, data: bytes, definitions: Definitions | None = None) -> dict[str, Any]:
    """
    Return the fields of a message.

    ``type_name``: for example ``sensor_msgs/msg/JointState``; ``definitions``: of this type and
    all that it is made of; default: the recorded type of that name.  Returned: numbers as int,
    float, bool; sequences of numbers as NumPy arrays; text as str; nested messages as dicts.
    """
    if definitions is None:
        definitions = definitions_of(type_name)
    if len(data) < 4:
        raise BagError(f'{type_name}: {len(data)} bytes; a message has at least 4')
    if data[0] != 0 or data[1] not in (0, 1):
        raise BagError(f'{type_name}: encapsulation {data[0]:#04x} {data[1]:#04x}; '
                       'only plain CDR is read')
    reader = _Reader(data, '<' if data[1] else '>', definitions, type_name)
    try:
        value = reader.message(type_name, 0)
    except StructError:
        raise BagError(f'{type_name}: ends in the middle of a field') from None
    # Fast DDS rounds a payload up to a multiple of four bytes.
    if len(data) - reader.at > 3:
        raise BagError(f'{type_name}: {len(data) - reader.at} bytes too many')
    return value


class _Reader:
    """A position in the bytes of one message."""

    def __init__(self, data: bytes, order: str, definitions: Definitions, name: str) -> None:
        self.data = data
        self.at = 4
        self.order = order
        self.definitions = definitions
        self.name = name
        self.length = Struct(order + 'I')

    def align(self, size: int) -> None:
        """Skip the padding before a field of this size."""
        self.at += -(self.at - 4) % size

    def count(self) -> int:
        """Return a 32-bit length that the rest of the bytes can hold."""
        self.align(4)
        number = self.length.unpack_from(self.data, self.at)[0]
        self.at += 4
        if number > len(self.data) - self.at:
            raise BagError(f'{self.name}: a length of {number} with '
                           f'{len(self.data) - self.at} bytes left')
        return number

    def text(self) -> str:
        """Return a text without its closing zero."""
        size = self.count()
        raw = self.data[self.at:self.at + size]
        self.at += size
        if size and raw[-1] != 0:
            raise BagError(f'{self.name}: a text without its closing zero')
        try:
            return bytes(raw[:-1]).decode()
        except UnicodeDecodeError:
            raise BagError(f'{self.name}: a text that is not UTF-8') from None

    def numbers(self, kind: str, number: int) -> np.ndarray:
        """Return numbers of one kind, in this machine's byte order."""
        dtype = np.dtype(self.order + kind)
        if number == 0:
            return np.empty(0, dtype.newbyteorder('='))
        self.align(dtype.itemsize)
        end = self.at + number * dtype.itemsize
        if end > len(self.data):
            raise BagError(f'{self.name}: {number} numbers with '
                           f'{len(self.data) - self.at} bytes left')
        values = np.frombuffer(self.data, dtype, number, self.at)
        self.at = end
        return values.astype(dtype.newbyteorder('='))

    def single(self, field: Field, depth: int) -> Any:
        """Return one element of a field."""
        if field.nested:
            return self.message(field.base, depth + 1)
        kind = PRIMITIVES[field.base]
        if kind is None:
            return self.text()
        value = self.numbers(kind, 1)[0].item()
        return bool(value) if field.base == 'bool' else value

    def message(self, name: str, depth: int) -> dict[str, Any]:
        """Return a message, its fields by name."""
        if depth > MAX_DEPTH:
            raise BagError(f'{self.name}: types nested deeper than {MAX_DEPTH}')
        fields = self.definitions.get(name)
        if fields is None:
            raise BagError(f'{self.name}: the definition of {name} is missing')
        if not fields:
            self.at += 1  # an empty message is one byte, as rosidl generates it
            if self.at > len(self.data):
                raise BagError(f'{self.name}: ends in the middle of a field')
        return {field.name: self.field(field, depth) for field in fields}

    def field(self, field: Field, depth: int) -> Any:
        """Return a field, whole."""
        if not field.array:
            return self.single(field, depth)
        number = field.size if field.array == 'fixed' else self.count()
        if number > len(self.data):
            raise BagError(f'{self.name}: {field.name} has {number} elements in '
                           f'{len(self.data)} bytes')
        if field.array == 'bounded' and number > field.size:
            raise BagError(f'{self.name}: {field.name} has {number} elements; '
                           f'at most {field.size}')
        kind = None if field.nested else PRIMITIVES[field.base]
        if kind is not None:
            return self.numbers(kind, number)
        return [self.single(field, depth) for _ in range(number)]


def encode(type_name: str, value: Mapping[str, Any],
           definitions: Definitions | None = None) -> bytes:
    """
    Return a message as little-endian CDR bytes with zero padding.

    ``type_name``: for example ``diagnostic_msgs/msg/DiagnosticArray``; ``value``: its fields;
    those left out are zero, empty or, as ROS does it, their elements' zeros; ``definitions``: of
    this type and all that it is made of; default: the recorded type of that name.
    """
    if definitions is None:
        definitions = definitions_of(type_name)
    out = bytearray(b'\x00\x01\x00\x00')
    _write_message(out, type_name, value, definitions)
    return bytes(out)


def _align(out: bytearray, size: int) -> None:
    out += bytes(-(len(out) - 4) % size)


def _write_message(out: bytearray, name: str, value: Mapping, definitions: Definitions) -> None:
    fields = definitions[name]
    unknown = set(value) - {field.name for field in fields}
    if unknown:
        raise ValueError(f'{name} has no field {sorted(unknown)[0]!r}')
    if not fields:
        out += b'\0'
    for field in fields:
        _write_field(out, field, value.get(field.name), definitions)


def _write_field(out: bytearray, field: Field, value: Any, definitions: Definitions) -> None:
    if not field.array:
        _write_single(out, field, value, definitions)
        return
    kind = None if field.nested else PRIMITIVES[field.base]
    if value is None:
        value = [] if field.array != 'fixed' else [None if kind is None else 0] * field.size
    limit = field.size if field.array != 'open' else len(value)
    if len(value) > limit or (field.array == 'fixed' and len(value) != limit):
        raise ValueError(f'{field.name} has {len(value)} elements; {limit} fit')
    if field.array != 'fixed':
        _align(out, 4)
        out += len(value).to_bytes(4, 'little')
    if kind is None:
        for each in value:
            _write_single(out, field, each, definitions)
    elif len(value):
        _write_numbers(out, kind, value)


def _write_numbers(out: bytearray, kind: str, values: Any) -> None:
    dtype = np.dtype('<' + kind)
    _align(out, dtype.itemsize)
    try:
        numbers = np.asarray(values, dtype)
    except (OverflowError, TypeError) as error:
        raise ValueError(str(error)) from None
    # before version 2 NumPy wraps an integer around
    if dtype.kind in 'iu' and not np.array_equal(numbers, values):
        raise ValueError(f'a number of {values} is none that fits {dtype.name}')
    out += numbers.tobytes()


def _write_single(out: bytearray, field: Field, value: Any, definitions: Definitions) -> None:
    kind = None if field.nested else PRIMITIVES[field.base]
    if field.nested:
        _write_message(out, field.base, value or {}, definitions)
    elif kind is None:
        data = (value or '').encode() + b'\0'
        if field.text_bound and len(data) > field.text_bound + 1:
            raise ValueError(f'{field.name} has {len(data) - 1} bytes; {field.text_bound} fit')
        _align(out, 4)
        out += len(data).to_bytes(4, 'little') + data
    else:
        _write_numbers(out, kind, [0 if value is None else value])
