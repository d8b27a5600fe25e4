"""Whether a solution has replaced functions of the packages with which it is judged."""

import sys
from typing import Any

#: Modules of which nothing may be replaced; what is added to them does no harm.
_WATCHED = ('builtins', 'math', 'numpy', 'numpy.linalg', 'numpy.random')

Attributes = dict[tuple[str, str], Any]


def attributes() -> Attributes:
    """Return what the judge's packages hold now: of this one, functions and classes."""
    found = {}
    for name, module in list(sys.modules.items()):
        ours = name.partition('.')[0] == 'ur5_ros'
        if ours or name in _WATCHED:
            found.update({(name, key): value for key, value in list(vars(module).items())
                          if key != '_' and (callable(value) or not ours)})
    return found


def replaced(before: Attributes) -> str:
    """Return the name of what is another thing than before; empty if all is as it was."""
    now = attributes()
    return next((f'{module}.{key}' for (module, key), value in before.items()
                 if now.get((module, key)) is not value), '')
