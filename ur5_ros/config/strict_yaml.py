"""YAML read strictly: no doubled key, no alias, no deep nest, no tag, bounded size."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.constructor import SafeConstructor
from yaml.resolver import Resolver

from ur5_ros.errors import InputError

MAX_BYTES = 1_000_000
MAX_DEPTH = 20


@cache
def config_folder() -> Path:
    """Return the folder ``config``: the checkout's, or the installed share folder."""
    here = Path(__file__).resolve()
    checkout = here.parents[2]
    if (checkout / 'package.xml').is_file() and (checkout / 'config' / 'arms').is_dir():
        return checkout / 'config'
    for prefix in here.parents:
        shared = prefix / 'share' / 'ur5_ros' / 'config'
        if (shared / 'arms').is_dir():
            return shared
    raise InputError(f'no folder share/ur5_ros/config above {here}; install the package again')


def file_names(kind: str) -> list[str]:
    """Return the names of the files of a kind, 'arm', 'experiment' or 'world', in the package."""
    return sorted(path.stem for path in (config_folder() / f'{kind}s').glob('*.yaml'))


def named_file(kind: str, name: str) -> Path:
    """Return the path of a file of the package by its name, or of any YAML file by its path."""
    if name.endswith(('.yaml', '.yml')) or '/' in name:
        path = Path(name).expanduser()
        if not path.is_file():
            raise InputError(f'no {kind} file {name}; give a path of a YAML file, '
                             f'or one of: {", ".join(file_names(kind))}')
        return path
    path = config_folder() / f'{kind}s' / f'{name}.yaml'
    if not path.is_file():
        raise InputError(f'unknown {kind} {name!r}; give one of: {", ".join(file_names(kind))}, '
                         'or the path of a YAML file')
    return path


try:
    from yaml.cyaml import CParser  # type: ignore[attr-defined]

    class _PlainLoader(Composer, CParser, SafeConstructor, Resolver):
        """SafeLoader whose parser is libyaml, which takes an eighth of the time."""

        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            for part in (Composer, SafeConstructor, Resolver):
                part.__init__(self)

except ImportError:  # PyYAML was built without libyaml
    from yaml import SafeLoader as _PlainLoader  # type: ignore[assignment]


class _Loader(_PlainLoader):
    """SafeLoader that refuses what would be silently lost or could blow up."""

    depth = 0

    def compose_node(self, parent, index):
        if self.check_event(yaml.events.AliasEvent):
            event: Any = self.peek_event()
            raise InputError(f'line {event.start_mark.line + 1}: alias *{event.anchor}; '
                             'write the value out')
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise InputError(f'nested deeper than {MAX_DEPTH} levels; make it flatter')
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                raise InputError(f'line {key_node.start_mark.line + 1}: key {key!r} is not a '
                                 'text; put it in quotes')
            if key in seen:
                raise InputError(f'line {key_node.start_mark.line + 1}: key {key!r} stands twice; '
                                 'remove one')
            seen.add(key)
        return super().construct_mapping(node, deep)


# YAML 1.1 takes 1e-3 for a text; YAML 1.2, which people write, for a number.
_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$'),
    list('-+.0123456789'))


def parse_yaml(text: str, source: str) -> Any:
    """
    Return the content of a YAML text.

    Returned: dicts, lists, strings, numbers, booleans, None.
    """
    if len(text) > MAX_BYTES:
        raise InputError(f'{source}: {len(text)} characters; at most {MAX_BYTES} are read')
    loader = None
    try:
        loader = _Loader(text)
        return loader.get_single_data()
    except InputError as error:
        raise InputError(f'{source}: {error}') from None
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        mark = getattr(error, 'problem_mark', None)
        place = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).partition('\n')[0]
        raise InputError(f'{source}{place}: not valid YAML: {problem}') from None
    finally:
        if loader is not None:
            loader.dispose()


def read_text(path: Path) -> str:
    """Return the text of a file, of a size that :func:`parse_yaml` takes."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f'{path}: {path.stat().st_size} bytes; at most {MAX_BYTES} are read')
        return path.read_text(encoding='utf-8')
    except FileNotFoundError:
        raise InputError(f'{path}: no such file; give the path of a YAML file') from None
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}') from None
    except UnicodeDecodeError:
        raise InputError(f'{path}: not a text file; give YAML in UTF-8') from None


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file; see :func:`parse_yaml`."""
    return parse_yaml(read_text(path), str(path))
