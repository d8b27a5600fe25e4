"""
Just enough of launch and launch_ros to run a launch file where neither is installed.

Arguments are declared, substitutions performed, conditions asked and functions called as launch
does it; what comes out is the command line of each node.
"""

import importlib.util
import sys
import types
from pathlib import Path
from typing import NamedTuple


class Started(NamedTuple):
    """A node as the launch file wants it."""

    executable: str
    arguments: list[str]
    parameters: list


class Configuration:
    """A launch argument, read when it is needed."""

    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return plain(context[self.name], context)


class Value(NamedTuple):
    """A parameter with the type that it is to have."""

    value: object
    value_type: type = str


class Action:
    """Any action: its words are kept."""

    def __init__(self, *words, condition=None, **named):
        self.words, self.condition, self.named = words, condition, named


class Declare(Action):
    pass


class Environment(Action):
    pass


class Group(Action):
    pass


class Include(Action):
    pass


class Function(Action):
    pass


class Node(Action):
    pass


def plain(value, context):
    """Return a value with every substitution performed."""
    if isinstance(value, Configuration):
        return value.perform(context)
    if isinstance(value, Value):
        said = plain(value.value, context)
        return said == 'true' if value.value_type is bool else value.value_type(said)
    if isinstance(value, dict):
        return {key: plain(each, context) for key, each in value.items()}
    return value


MODULES = {
    'launch': {'LaunchDescription': list, 'LaunchContext': dict},
    'launch.actions': {
        'DeclareLaunchArgument': Declare, 'GroupAction': Group,
        'IncludeLaunchDescription': Include, 'OpaqueFunction': Function,
        'SetEnvironmentVariable': Environment, 'Shutdown': Action,
        'UnsetEnvironmentVariable': Environment},
    'launch.conditions': {'IfCondition': lambda asked: asked},
    'launch.launch_description_sources': {'PythonLaunchDescriptionSource': str},
    'launch.substitutions': {'LaunchConfiguration': Configuration},
    'launch_ros': {},
    'launch_ros.actions': {'Node': Node},
    'launch_ros.parameter_descriptions': {'ParameterValue': Value},
}


def description(path: Path) -> list[Action]:
    """Return what a launch file describes."""
    before = {name: sys.modules.get(name) for name in MODULES}
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
                del sys.modules[name]
            else:
                sys.modules[name] = module


def launch(path: Path, **given: str) -> tuple[list[Started], dict]:
    """Run a launch file; return its nodes and the variables of the environment it sets."""
    context: dict = dict(given)
    nodes: list[Started] = []
    environment: dict = {}
    undeclared = set(given)

    def visit(actions) -> None:
        for action in actions:
            if isinstance(action, Declare):
                name = action.words[0]
                undeclared.discard(name)
                context.setdefault(name, action.named['default_value'])
                choices = action.named.get('choices')
                assert choices is None or plain(context[name], context) in choices
                assert action.named['description']
            if action.condition and plain(action.condition, context).lower() != 'true':
                continue
            if isinstance(action, Group):
                visit(action.words[0])
            elif isinstance(action, Environment):
                environment[action.words[0]] = (action.words[1:] or ('',))[0]
            elif isinstance(action, Function):
                visit(action.named['function'](context))
            elif isinstance(action, Include):
                passed = {name: plain(value, context)
                          for name, value in action.named['launch_arguments']}
                nodes.extend(launch(Path(action.words[0]), **passed)[0])
            elif isinstance(action, Node):
                nodes.append(started(action.named, context))

    visit(description(path))
    assert not undeclared, f'{path.name} does not declare {undeclared}'
    return nodes, environment


def started(words: dict, context: dict) -> Started:
    """Return the command line of a node."""
    arguments = [plain(each, context) for each in words.get('arguments', [])] + ['--ros-args']
    if words.get('name'):
        arguments += ['-r', f'__node:={plain(words["name"], context)}']
    if namespace := plain(words.get('namespace', ''), context):
        arguments += ['-r', f'__ns:=/{namespace}']
    parameters = [plain(each, context) for each in words['parameters']]
    for each in parameters:
        if isinstance(each, str):
            arguments += ['--params-file', each]
            continue
        for name, value in each.items():
            said = str(value).lower() if isinstance(value, bool) else value
            quoted = f"'{said}'" if isinstance(value, str) else said
            arguments += ['-p', f'{name}:={quoted}']
    return Started(words['executable'], arguments, parameters)
