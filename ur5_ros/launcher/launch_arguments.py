"""Launch arguments: texts that people type, as the values that nodes take."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ur5_ros.config.parameter_files import matches, sections
from ur5_ros.errors import InputError

_BOOLEANS = {'true': True, '1': True, 'false': False, '0': False}
#: How people write an empty text, which the command line of launch does not take.
_EMPTY = ("''", '""')


class Argument(NamedTuple):
    """One argument of a launch file."""

    default: Any
    """A text, or a substitution of launch; empty where the node or its file decides."""
    description: str
    kind: str = 'text'
    """``text``, ``boolean``, ``integer``, ``number``, ``bag`` or ``file``."""
    choices: tuple[str, ...] = ()


def read_arguments(
    arguments: Mapping[str, Argument], texts: Mapping[str, str],
) -> dict[str, Any]:
    """
    Return the values of launch arguments.

    Returned: name to value; an empty argument is left out, so that the node or its file decides.
    """
    values = {}
    for name, argument in arguments.items():
        value = _value(name, argument, texts[name].strip())
        if value is not None:
            values[name] = value
    return values


def given(values: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Return those of ``names`` that have a value, as parameters of a node."""
    return {name: values[name] for name in names if name in values}


def parameter_files(values: Mapping[str, Any], *node_names: str) -> list[list[str]]:
    """
    Return for each node the files of ``params_file`` that have a section for it.

    Returned: one list a node: empty or with the path.
    """
    path = values.get('params_file')
    if path is None:
        return [[] for _ in node_names]
    found = sections(Path(path))
    files = [[path] if any(matches(section, name) for section in found) else []
             for name in node_names]
    if not any(files):
        raise InputError(f'params_file: {path} has no section for {" or ".join(node_names)} '
                         f'(sections: {", ".join(found) or "none"}); rename one, or use /**')
    return files


def node_name(namespace: str, name: str) -> str:
    """Return the fully qualified name of a node."""
    return '/' + '/'.join(part for part in (*namespace.split('/'), name) if part)


def require_packages(*names: str) -> None:
    """Refuse, before anything is started, packages that are not installed."""
    # only where ROS or its packages from PyPI are installed
    from ament_index_python import PackageNotFoundError, get_package_prefix
    for name in names:
        try:
            get_package_prefix(name)
        except (PackageNotFoundError, OSError):
            raise InputError(f'the package {name} is not installed; install '
                             f'ros-jazzy-{name.replace("_", "-")}, or do without it') from None


def _value(name: str, argument: Argument, text: str) -> Any:
    """Return the value of one argument; None where it is empty."""
    kind = argument.kind
    if not text:
        return None
    if argument.choices and text not in argument.choices:
        raise _refusal(name, text, f'one of: {", ".join(argument.choices)}')
    if kind == 'boolean':
        if text.lower() not in _BOOLEANS:
            raise _refusal(name, text, 'true or false')
        return _BOOLEANS[text.lower()]
    if kind in ('integer', 'number'):
        return _number(name, kind, text)
    if kind == 'bag':
        return 'none' if text in _EMPTY else text
    if kind == 'file' and not Path(text).is_file():
        raise _refusal(name, text, 'the path of a file that exists')
    return text


def _number(name: str, kind: str, text: str) -> int | float:
    convert, expected = (int, 'a whole number') if kind == 'integer' else (float, 'a number')
    try:
        number = convert(text)
    except ValueError:
        raise _refusal(name, text, expected) from None
    if not math.isfinite(number):
        raise _refusal(name, text, 'a finite number')
    return number


def _refusal(name: str, text: str, expected: str) -> InputError:
    return InputError(f'launch argument {name} is {text!r}; give {expected}')
