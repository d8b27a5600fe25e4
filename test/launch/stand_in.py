"""
Just enough of launch and launch_ros to run a launch file where neither is installed.

Arguments are declared, substitutions performed and functions called as launch does it; what comes
out is the command line of each node, its parameters in temporary files as launch_ros writes them.
"""

import importlib.util
import sys
import tempfile
import types
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import yaml


class Started(NamedTuple):
    """A node as the launch file starts it."""

    executable: str
    arguments: list[str]
    parameters: list
    on_exit: object


class Configuration:
    """A launch argument, read when it is needed."""

    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return plain(context[self.name], context)


class Action:
    """Any action: its words are kept."""

    def __init__(self, *words, **named):
        self.words, self.named = words, named


class Declare(Action):
    pass


class Environment(Action):
    pass


class Include(Action):
    pass


class Function(Action):
    pass


class Node(Action):
    pass


class Shutdown(Action):
    pass


def plain(value, context):
    """Return a value with every substitution performed."""
    return value.perform(context) if isinstance(value, Configuration) else value


MODULES = {
    'launch': {'LaunchDescription': list, 'LaunchContext': dict},
    'launch.actions': {
        'DeclareLaunchArgument': Declare, 'IncludeLaunchDescription': Include,
        'OpaqueFunction': Function, 'SetEnvironmentVariable': Environment, 'Shutdown': Shutdown,
        'UnsetEnvironmentVariable': Environment},
    'launch.launch_description_sources': {'PythonLaunchDescriptionSource': str},
    'launch.substitutions': {'LaunchConfiguration': Configuration},
    'launch_ros': {},
    'launch_ros.actions': {'Node': Node},
}
#: Where parameter files go until the interpreter ends.
FILES = tempfile.TemporaryDirectory(prefix='launch_')
#: Module of the package that keeps what it imported from launch.
SHARED = 'ur5_ros.launcher.launch_file'


def description(path: Path) -> list[Action]:
    """Return what a launch file describes."""
    before = {name: sys.modules.get(name) for name in (*MODULES, SHARED)}
    sys.modules.pop(SHARED, None)
    try:
        for name, members in MODULES.items():
            sys.modules[name] = types.ModuleType(name)
            vars(sys.modules[name]).update(members)
        spec = importlib.util.spec_from_file_location(f'launch_file_{path.name[:-10]}', path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.generate_launch_description()
    finally:
        for name, module in before.items():
            if module is None:
                sys.modules.pop(name, None)
            else:
                sys.modules[name] = module


def launch(path: Path, **given: str) -> tuple[list[Started], dict]:
    """Run a launch file; return its nodes and the variables of the environment it sets."""
    context: dict = {}
    for name, text in given.items():
        if not text:  # launch refuses `name:=` on its command line
            raise ValueError(f'malformed launch argument {name}:={text}')
        context[name] = text
    return _launch(path, context, set(given))


def _launch(path: Path, context: dict, undeclared: set[str]) -> tuple[list[Started], dict]:
    nodes: list[Started] = []
    environment: dict = {}

    def visit(actions) -> None:
        for action in actions:
            if isinstance(action, Declare):
                name = action.words[0]
                undeclared.discard(name)
                context.setdefault(name, action.named['default_value'])
                assert action.named['description']
            elif isinstance(action, Environment):
                environment[action.words[0]] = (action.words[1:] or ('',))[0]
            elif isinstance(action, Function):
                visit(action.named['function'](context))
            elif isinstance(action, Include):
                # what is passed stays set in the including file, as in launch
                context.update({name: plain(value, context)
                                for name, value in action.named['launch_arguments']})
                nodes.extend(_launch(Path(action.words[0]), context, set())[0])
            elif isinstance(action, Node):
                nodes.append(started(action.named, context))

    visit(description(path))
    assert not undeclared, f'{path.name} does not declare {undeclared}'
    return nodes, environment


def started(words: dict, context: dict) -> Started:
    """Return the command line of a node, as launch_ros composes it."""
    namespace = '/' + plain(words.get('namespace', ''), context).strip('/')
    name = plain(words.get('name', ''), context)
    arguments = [plain(each, context) for each in words.get('arguments', [])] + ['--ros-args']
    if name:
        arguments += ['-r', f'__node:={name}']
    arguments += ['-r', f'__ns:={namespace}', *words.get('ros_arguments', [])]
    for before, after in words.get('remappings', []):
        arguments += ['-r', f'{before}:={after}']
    parameters = []
    for each in words['parameters']:
        if isinstance(each, str):
            parameters.append(each)
            arguments += ['--params-file', each]
            continue
        values = {key: evaluated(plain(value, context)) for key, value in each.items()}
        parameters.append(values)
        section = f'{namespace.rstrip("/")}/{name}' if name else '/**'
        arguments += ['--params-file', parameter_file(section, values)]
    return Started(words['executable'], arguments, parameters, words.get('on_exit'))


def evaluated(value):
    """Return a value as launch_ros evaluates it: a list is a tuple of one type, and not empty."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        kinds = {type(item) for item in value}
        if kinds == {int, float}:
            value, kinds = [float(item) for item in value], {float}
        if len(kinds) != 1 or not kinds <= {bool, int, float, str}:
            raise TypeError(f'expected a sequence of one type, not empty: {value!r}')
        return tuple(value)
    if type(value) not in (bool, int, float, str):
        raise TypeError(f'{value!r} can be no parameter')
    return value


def parameter_file(section: str, values: dict) -> str:
    """Return the path of a file that holds parameters as launch_ros writes them, tags included."""
    with tempfile.NamedTemporaryFile('w', prefix='launch_params_', dir=FILES.name,
                                     delete=False) as file:
        yaml.dump({section: {'ros__parameters': values}}, file, default_flow_style=False)
    return file.name
