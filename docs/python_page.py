"""The page docs/reference/python.md, from the docstrings of the public names."""

import ast
import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import ur5_ros

#: What the public functions take and return.
VALUES = {
    'model.parameters': ('ArmParameters', 'Limits', 'Payload'),
    'model.inverse_kinematics': ('Solutions',),
    'control.output': ('ControlOutput',),
    'loop.run_config': ('RunConfig',),
    'loop.loop_run': ('LoopRun',),
    'bag.reader': ('Bag',),
    'bag.arrays.columns': ('Columns',),
    'analysis.data.run': ('Run', 'States', 'NodeRecord', 'RecordedEvent'),
    'analysis.result': ('Result', 'Check'),
    'analysis.identification.identify': ('Identified',),
}

INTRODUCTION = """# Python

Written by `docs/generate.py` from the docstrings. `import ur5_ros` gives the names of this page,
each imported when it is first used. Every other name of the package is internal: it may change in
any version. Angles, units and frames: [conventions](../conventions.md). Functions broadcast over
leading dimensions and refuse numbers that are not finite.
"""
SECTIONS = {
    'Arms and states': ('load_arm', 'JOINT_NAMES', 'ArmState', 'Reference', 'Torque'),
    'Kinematics': ('forward_kinematics', 'link_transforms', 'jacobian', 'jacobian_rate',
                   'singularity_factors',
                   'inverse_kinematics', 'inverse_kinematics_batch', 'nearest_solution'),
    'Dynamics': ('inertia_matrix', 'coriolis_matrix', 'gravity_torque', 'dynamics_terms',
                 'inverse_dynamics', 'forward_dynamics', 'dynamics_regressor',
                 'kinetic_energy', 'potential_energy'),
    'Control and simulation': ('Gains', 'computed_torque', 'Controller', 'Plant', 'run_config',
                               'run_closed_loop'),
    'Judging recordings': ('open_bag', 'load_run', 'validate', 'identify', 'InputError'),
}


def page() -> str:
    """Return the page."""
    lines = [INTRODUCTION]
    for title, names in SECTIONS.items():
        lines += [f'## {title}', '']
        for name in names:
            lines += _entry(name, getattr(ur5_ros, name))
    lines += ['## Values', '', 'What these functions take and return; not imported by name.', '']
    for module, names in VALUES.items():
        for name in names:
            lines += _entry(name, getattr(import_module(f'ur5_ros.{module}'), name))
    return '\n'.join(lines)


def _entry(name: str, value: Any) -> list[str]:
    if not callable(value):
        return [f'### {name}', '', '`' + ', '.join(value) + '`', '']
    lines = [f'### {name}', '', f'`{name}{_signature(value)}`', '', *_docstring(value)]
    if inspect.isclass(value):
        fields = _fields(value)
        if fields:
            lines += ['| field | |', '|---|---|']
            lines += [f'| `{field}` | {_inline(text)} |' for field, text in fields.items()]
            lines.append('')
        methods = [_method(name, method) for name, method in _methods(value)]
        lines += [*methods, ''] if methods else []
    return lines


def _method(name: str, method: Any) -> str:
    summary = _inline(inspect.getdoc(method).split('\n\n')[0])
    return f'- `{name}{"" if isinstance(method, property) else _signature(method)}`: {summary}'


def _signature(value: Any) -> str:
    """Return the names of the parameters with their defaults; types stand in the docstring."""
    if inspect.isclass(value) and issubclass(value, Exception):
        return '(message)'
    parameters = inspect.signature(value).parameters.values()
    shown = [parameter.replace(annotation=inspect.Parameter.empty) for parameter in parameters
             if parameter.name not in ('self', '_cls')]
    return str(inspect.Signature(shown))


def _methods(value: type) -> Iterator[tuple[str, Any]]:
    for name, method in vars(value).items():
        if not name.startswith('_') and (inspect.isfunction(method)
                                         or isinstance(method, property)):
            yield name, method


def _fields(value: type) -> dict[str, str]:
    """Return the fields of a NamedTuple or a dataclass, with the strings that follow them."""
    names = getattr(value, '_fields', None) or getattr(value, '__dataclass_fields__', ())
    if not names:
        return {}
    body = ast.parse(inspect.getsource(value)).body[0].body
    found, last = dict.fromkeys(names, ''), ''
    for statement in body:
        if isinstance(statement, ast.AnnAssign):
            last = statement.target.id
        elif last and isinstance(statement, ast.Expr):
            found[last] = inspect.cleandoc(statement.value.value)
    return found


def _docstring(value: Any) -> list[str]:
    """Return a NumPy docstring as Markdown."""
    head, *rest = re.split(r'^(\w+)\n-+\n', inspect.getdoc(value), flags=re.MULTILINE)
    lines = [_inline(paragraph) + '\n' for paragraph in head.strip().split('\n\n')]
    for title, text in zip(rest[::2], rest[1::2], strict=True):
        if title == 'Examples':
            lines += _example(text)
        else:
            lines += [f'{title}:', '', *_items(text), '']
    return lines


def _items(text: str) -> list[str]:
    """Return the entries of a section as a list."""
    items: list[str] = []
    for line in text.strip().splitlines():
        if not line.startswith(' ') and line:
            name, colon, kind = line.partition(' : ')
            items.append(f'- `{name}`{colon and f" ({kind})"}:')
        elif line:
            items[-1] += ' ' + line.strip()
    return [_inline(item).rstrip(':') for item in items]


def _example(text: str) -> list[str]:
    """Return an example as a block to copy; what it prints stands in comments."""
    code = []
    for line in text.strip().splitlines():
        code.append(line[4:] if line.startswith(('>>> ', '... ')) else f'# {line}')
    return ['<!-- test: none, test/docs/test_python_api.py runs it -->', '```python', *code,
            '```', '']


def _inline(text: str) -> str:
    """Return text of a docstring in one line, its roles as code."""
    text = re.sub(r':math:`(.+?)`', r'`\1`', ' '.join(text.split()))
    text = re.sub(r':\w+:`~?(?:[\w.]+\.)?([^`]+)`', r'`\1`', text)
    return text.replace('``', '`').replace('|', '\\|')
