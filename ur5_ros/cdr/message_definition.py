"""Message definitions in ros2msg text, parsed within bounds."""

import re
from typing import NamedTuple

from ur5_ros.errors import BagError

#: Bounds on a schema found in a bag. The largest of common_interfaces has 9 parts and 60 fields.
MAX_TEXT = 200_000
MAX_PARTS = 100
MAX_FIELDS = 500

#: Primitive types of .msg files: numpy type, None for text.
PRIMITIVES = {'bool': 'u1', 'byte': 'u1', 'char': 'u1', 'int8': 'i1', 'uint8': 'u1',
              'int16': 'i2', 'uint16': 'u2', 'int32': 'i4', 'uint32': 'u4', 'int64': 'i8',
              'uint64': 'u8', 'float32': 'f4', 'float64': 'f8', 'string': None}

_FIELD = re.compile(r'^(?P<base>[A-Za-z][\w/]*)(?:<=(?P<bound>\d{1,9}))?'
                    r'(?:\[(?P<array>(?:<=)?\d{0,9})\])?\s+(?P<name>[A-Za-z]\w*)'
                    r'\s*(?P<rest>.*)$')


class Field(NamedTuple):
    """One field of a message."""

    name: str
    base: str
    """Primitive type, or ``package/msg/Name``."""
    nested: bool
    array: str
    """Empty for a single value, else 'fixed', 'bounded' or 'open'."""
    size: int
    """Length of a fixed array, bound of a bounded sequence, else 0."""
    text_bound: int
    """Longest text allowed, 0 for any."""


Definition = tuple[Field, ...]


def parse_definition(type_name: str, text: str) -> Definition:
    """
    Return the fields of one .msg file, without constants and defaults; BagError for a bad line.

    The package of ``type_name`` completes unqualified types.

    """
    package = type_name.partition('/')[0]
    fields = []
    for line in text.split('\n'):
        line = line.partition('#')[0].strip()
        if not line:
            continue
        found = _FIELD.match(line)
        if not found:
            raise BagError(f'schema of {type_name}: cannot read the line {line[:60]!r}')
        if found['rest'].startswith('='):
            continue
        base, array = found['base'], found['array']
        nested = base not in PRIMITIVES
        if nested:
            base = _full_name(base, package)
        number = (array or '').removeprefix('<=')
        kind = '' if array is None else 'open' if array == '' else \
            'bounded' if array.startswith('<=') else 'fixed'
        if kind in ('bounded', 'fixed') and not number:
            raise BagError(f'schema of {type_name}: cannot read the line {line[:60]!r}')
        fields.append(Field(found['name'], base, nested, kind, int(number or 0),
                            int(found['bound'] or 0)))
        if len(fields) > MAX_FIELDS:
            raise BagError(f'schema of {type_name}: more than {MAX_FIELDS} fields')
    return tuple(fields)


def parse_schema(type_name: str, text: str) -> dict[str, Definition]:
    """
    Return all definitions of a ros2msg schema: the type's own and those that it depends on.

    BagError if the text is too large, cannot be read, lacks a dependency or contains itself.

    """
    if len(text) > MAX_TEXT:
        raise BagError(f'schema of {type_name}: {len(text)} characters; '
                       f'at most {MAX_TEXT} are read')
    parts = re.split(r'^={80,}[ \t]*\r?\n', text.replace('\r\n', '\n'), flags=re.MULTILINE)
    if len(parts) > MAX_PARTS:
        raise BagError(f'schema of {type_name}: more than {MAX_PARTS} parts')
    definitions = {type_name: parse_definition(type_name, parts[0])}
    for part in parts[1:]:
        head, _, body = part.partition('\n')
        if not head.startswith('MSG: '):
            raise BagError(f'schema of {type_name}: a part starts with {head[:60]!r}, '
                           "not with 'MSG: package/Name'")
        name = _full_name(head.removeprefix('MSG: ').strip(), '')
        definitions[name] = parse_definition(name, body)
    _check_closed(type_name, definitions)
    return definitions


def _full_name(name: str, package: str) -> str:
    """Return ``package/msg/Name`` of any of the three ways to write a type."""
    parts = name.split('/')
    if name == 'Header':
        return 'std_msgs/msg/Header'
    if len(parts) == 1:
        return f'{package}/msg/{name}'
    if len(parts) == 2:
        return f'{parts[0]}/msg/{parts[1]}'
    return name


def _check_closed(type_name: str, definitions: dict[str, Definition]) -> None:
    """Refuse a missing dependency and a type that contains itself."""
    finished: set[str] = set()

    def visit(name: str, inside: tuple[str, ...]) -> None:
        if name in finished:
            return
        if name in inside:
            raise BagError(f'schema of {type_name}: {name} contains itself')
        if name not in definitions:
            raise BagError(f'schema of {type_name}: the definition of {name} is missing')
        for field in definitions[name]:
            if field.nested:
                visit(field.base, (*inside, name))
        finished.add(name)

    visit(type_name, ())
