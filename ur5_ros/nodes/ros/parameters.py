"""Parameters as ROS knows them, from the declarations in :mod:`ur5_ros.config.parameters`."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from ur5_ros.config import read_yaml
from ur5_ros.config.node_parameters import Record
from ur5_ros.config.parameters import Parameter, check
from ur5_ros.errors import InputError

_OF_EVERY_NODE = ('use_sim_time', 'start_type_description_service')


def declare(node: Node, record: type[Record], elsewhere: Collection[str] = ()) -> Record:
    """
    Declare parameters with ranges and return a checked value for each.

    Parameters
    ----------
    node : rclpy.node.Node
        A node that has declared none of them yet.
    record : type
        The record of the node's parameters.
    elsewhere : collection of str
        Names given to all nodes of the process that another one declares.

    Raises
    ------
    InputError
        If a given one is unknown or its value is refused.

    """
    # rclpy has no public way to ask for the names of overrides that are not declared
    given = {name: _plain(override.value) for name, override in node._parameter_overrides.items()
             if name not in _OF_EVERY_NODE and not name.startswith('qos_overrides.')}
    declared = {each.name for each in record.declared}
    given = {name: value for name, value in given.items()
             if name in declared or name not in elsewhere}
    parameters = record.of(given)
    values = parameters.by_name()
    node.declare_parameters(
        '', [(each.name, values[each.name], _descriptor(each)) for each in record.declared],
        ignore_override=True)
    return parameters


def serve(
    node: Node, parameters: Sequence[Parameter], change: Callable[[dict[str, Any]], None],
) -> None:
    """
    Let ``change(changes)`` have every live change; what it refuses is refused.

    Parameters
    ----------
    node : rclpy.node.Node
        The node that declared them.
    parameters : sequence of Parameter
        The same as declared.
    change : callable
        Takes checked values by name into effect, all or none; raises InputError.

    """
    known = {each.name: each for each in parameters}

    def convert(given: list[RosParameter]) -> list[RosParameter]:
        """Make ``kp: 5`` as good as ``kp: [5.0]``; leave what is wrong to the check."""
        return [_converted(known.get(each.name), each) for each in given]

    def judge(given: list[RosParameter]) -> SetParametersResult:
        try:
            if any(each.name == 'use_sim_time' and each.value for each in given):
                raise InputError('use_sim_time cannot be set while the node runs')
            checked = {each.name: check(known[each.name], _plain(each.value))
                       for each in given if each.name in known}
            if checked:
                change(checked)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_pre_set_parameters_callback(convert)
    node.add_on_set_parameters_callback(judge)


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    description = parameter.description
    if parameter.choices:
        description += f' One of: {", ".join(parameter.choices)}.'
    descriptor = ParameterDescriptor(
        name=parameter.name, description=description, read_only=not parameter.live,
        # an empty list has no type in rclpy
        dynamic_typing=0 in parameter.sizes,
    )
    if type(parameter.default) is int:
        descriptor.integer_range = [IntegerRange(
            from_value=int(parameter.lower), to_value=int(parameter.upper))]
    elif type(parameter.default) is float:
        descriptor.floating_point_range = [FloatingPointRange(
            from_value=float(parameter.lower), to_value=float(parameter.upper))]
    return descriptor


def _converted(parameter: Parameter | None, given: RosParameter) -> RosParameter:
    if parameter is None:
        return given
    try:
        return RosParameter(given.name, value=check(parameter, _plain(given.value)))
    except InputError:
        return given


def _plain(value: Any) -> Any:
    """Return a list where rclpy has an array; it has None where an empty list is given."""
    if value is None:
        return []
    return list(value) if hasattr(value, '__len__') and not isinstance(value, str) else value


def read_files(arguments: Sequence[str]) -> dict[str, Any]:
    """
    Return the parameter files of a command line, read strictly: rcl reads past doubled keys.

    Parameters
    ----------
    arguments : sequence of str
        Command line.

    Returns
    -------
    dict
        Path to what the file says.

    Raises
    ------
    InputError
        If one cannot be read, or is no strict YAML with sections.

    """
    paths = [after for before, after in pairwise(arguments) if before == '--params-file']
    files = {path: read_yaml(Path(path)) for path in paths}
    for path, data in files.items():
        if not isinstance(data, Mapping):
            raise InputError(f'{path}: no sections; give "/node_name: ros__parameters: ..."')
    return files


def check_sections(files: Mapping[str, Any], *node_names: str) -> None:
    """
    Refuse parameter files that say nothing to a node: rcl reads past them in silence.

    Parameters
    ----------
    files : mapping
        From :func:`read_files`.
    *node_names : str
        Fully qualified names of the nodes of the process.

    Raises
    ------
    InputError
        If a file has no section for any of them.

    """
    for path, data in files.items():
        sections = list(_sections(data, ''))
        if not any(matches(section, name) for section in sections for name in node_names):
            found, name = ', '.join(sections) or 'none', ' or '.join(node_names)
            raise InputError(f'{path}: no section for {name} (sections: {found}); '
                             f'rename one to {node_names[0]}, or to /**')


def matches(section: str, node_name: str) -> bool:
    """
    Return whether a section of a parameter file speaks to a node, as rcl reads it.

    ``*`` stands for one part of a name, ``**`` for any number of them; a section without a
    leading slash is taken from the root.

    """
    return _match(_parts(section), _parts(node_name))


def _match(pattern: list[str], name: list[str]) -> bool:
    if not pattern:
        return not name
    if pattern[0] == '**':
        return any(_match(pattern[1:], name[i:]) for i in range(len(name) + 1))
    return bool(name) and pattern[0] in ('*', name[0]) and _match(pattern[1:], name[1:])


def _parts(name: str) -> list[str]:
    return [part for part in name.split('/') if part]


def _sections(data: Mapping[str, Any], above: str) -> Iterable[str]:
    """Yield the node names in a parameter file: the keys above ``ros__parameters``."""
    for key, value in data.items():
        if key == 'ros__parameters':
            yield above or '/'
        elif isinstance(value, Mapping):
            yield from _sections(value, f'{above}/{key.strip("/")}')
