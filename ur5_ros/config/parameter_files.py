"""Parameter files of ROS nodes: which nodes they name. Their values are read by rcl alone."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import yaml

from ur5_ros.config.strict_yaml import read_text
from ur5_ros.errors import InputError

try:
    from yaml import CSafeLoader as _Loader
except ImportError:  # PyYAML was built without libyaml
    from yaml import SafeLoader as _Loader  # type: ignore[assignment]


def sections(path: Path) -> list[str]:
    """
    Return the node names to which a parameter file gives parameters.

    Values and tags are not looked at: launch_ros writes a list as ``!!python/tuple``.

    ``path``: file of ``--params-file``.  Returned: such as ``/ur5_sim`` or ``/**``, in the order
    of the file.
    """
    try:
        text = read_text(path)
        _check_aliases(path, text)
        root = yaml.compose(text, _Loader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        place = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).partition('\n')[0]
        raise InputError(f'{path}{place}: not valid YAML: {problem}') from None
    if not isinstance(root, yaml.MappingNode):
        raise InputError(f'{path}: no sections; give "/node_name: ros__parameters: ..."')
    try:
        _check_keys(root)
    except InputError as error:
        raise InputError(f'{path}, {error}') from None
    return list(_sections(root, ''))


def matches(section: str, node_name: str) -> bool:
    """
    Return whether a section of a parameter file applies to a node, by the rules of rcl.

    ``*`` stands for one part of a name, ``**`` for any number of them; a section without a
    leading slash is taken from the root.

    """
    return _match(_parts(section), _parts(node_name))


def files_of(arguments: Sequence[str]) -> list[Path]:
    """Return the parameter files of a command line."""
    return [Path(after) for before, after in pairwise(arguments) if before == '--params-file']


def require_sections(files: Iterable[Path], *node_names: str) -> None:
    """Refuse parameter files without a section for a process: rcl reads past them in silence."""
    for path in files:
        found = sections(path)
        if not any(matches(section, name) for section in found for name in node_names):
            raise InputError(f'{path}: no section for {" or ".join(node_names)} (sections: '
                             f'{", ".join(found) or "none"}); rename one to {node_names[0]}, '
                             'or to /**')


def _match(pattern: list[str], name: list[str]) -> bool:
    if not pattern:
        return not name
    if pattern[0] == '**':
        return any(_match(pattern[1:], name[i:]) for i in range(len(name) + 1))
    return bool(name) and pattern[0] in ('*', name[0]) and _match(pattern[1:], name[1:])


def _parts(name: str) -> list[str]:
    return [part for part in name.split('/') if part]


def _check_aliases(path: Path, text: str) -> None:
    """Refuse an alias: nodes that refer to each other can be endless."""
    for event in yaml.parse(text, _Loader):
        if isinstance(event, yaml.AliasEvent):
            raise InputError(f'{path}: alias *{event.anchor}; write the value out')


def _check_keys(node: yaml.Node) -> None:
    """Refuse a mapping in which a key stands twice."""
    if not isinstance(node, yaml.MappingNode):
        return
    seen = set()
    for key, value in node.value:
        if isinstance(key, yaml.ScalarNode):
            if key.value in seen:
                raise InputError(f'line {key.start_mark.line + 1}: key {key.value!r} stands '
                                 'twice; remove one')
            seen.add(key.value)
        _check_keys(value)


def _sections(mapping: yaml.MappingNode, above: str) -> Iterator[str]:
    """Yield the node names: the keys above ``ros__parameters``."""
    for key, value in mapping.value:
        if key.value == 'ros__parameters':
            yield above or '/'
        elif isinstance(value, yaml.MappingNode) and isinstance(key.value, str):
            yield from _sections(value, f'{above}/{key.value.strip("/")}')
