"""What ``--help`` of a node prints: how it is called, and its parameters."""

from collections.abc import Iterable
from textwrap import fill

from ur5_ros.config.parameters import Parameter

_CALL = """\
usage: {program} [--ros-args [-p NAME:=VALUE]... [-r FROM:=TO]...
    [--params-file FILE]]

{purpose}
Ctrl-C ends it. Topics, services and parameters: docs/reference.

Parameters with their defaults; (live): can change while the node runs
"""


def usage(program: str, purpose: str, parameters: Iterable[Parameter]) -> str:
    """Return the text of ``--help``, at most 80 columns wide."""
    lines = [_CALL.format(program=program, purpose=fill(purpose, 80))]
    for parameter in parameters:
        live = ' (live)' if parameter.live else ''
        lines.append(f'  {parameter.name}: {_default(parameter.default)}{live}')
        lines.append(fill(parameter.description, 80, initial_indent=' ' * 6,
                          subsequent_indent=' ' * 6))
    return '\n'.join(lines)


def _default(value: object) -> str:
    if isinstance(value, list):
        return '[' + ', '.join(f'{each:.4g}' for each in value) + ']'
    return repr(value) if isinstance(value, str) else str(value).lower()
