"""Parameters as ROS knows them, from the declarations in :mod:`ur5_ros.config.parameters`."""

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
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

from ur5_ros.config.node_parameters import Record
from ur5_ros.config.parameter_files import require_sections
from ur5_ros.config.parameters import Parameter, check
from ur5_ros.config.strict_yaml import parse_yaml
from ur5_ros.errors import InputError

_NUMBERS = RosParameter.Type.DOUBLE_ARRAY
_OF_EVERY_NODE = ('use_sim_time', 'start_type_description_service')


def open_node(name: str, files: list[Path], record: type[Record],
              elsewhere: Collection[str]) -> tuple[Node, Record]:
    """Return a node and its parameters; parameter files have a section for it."""
    node = Node(name)
    require_sections(files, node.get_fully_qualified_name())
    return node, declare(node, record, elsewhere)


def declare(node: Node, record: type[Record], elsewhere: Collection[str] = ()) -> Record:
    """Declare parameters with ranges and return a checked value for each."""
    # rclpy has no public way to ask for the names of overrides that are not declared
    given = {name: _plain(override.value) for name, override in node._parameter_overrides.items()
             if name not in _OF_EVERY_NODE and not name.startswith('qos_overrides.')}
    declared = {each.name for each in record.declared}
    given = {name: value for name, value in given.items()
             if name in declared or name not in elsewhere}
    parameters = record.of(given)
    values = parameters.by_name()
    node.declare_parameters(
        '', [(each.name, _NUMBERS if values[each.name] == [] else values[each.name],
              _descriptor(each)) for each in record.declared], ignore_override=True)
    # rclpy takes an empty list for bytes unless the type is given beside it
    node.set_parameters([_ros_parameter(each, []) for each in record.declared
                         if values[each.name] == []])
    return parameters


def update(node: Node, before: Record, after: Record) -> Record:
    """Set the declared parameters that a start has worked out anew; return the record of all."""
    declared = before.by_name()
    node.set_parameters([RosParameter(name, value=value) for name, value in
                         after.by_name().items() if value != declared[name]])
    return after


def serve(
    node: Node, parameters: Sequence[Parameter], change: Callable[[dict[str, Any]], None],
    prepare: Callable[[dict[str, Any]], None],
) -> None:
    """
    Pass every live change to ``change(changes)``; what that refuses is refused.

    From here on what is not live is read-only; until then the start may set it.

    ``change``: takes checked values by name into effect, all or none; raises InputError.
    """
    known = {each.name: each for each in parameters}

    wrong: list[InputError] = []

    def convert(given: list[RosParameter]) -> list[RosParameter]:
        """Accept ``kp: 5`` for ``kp: [5.0]``; what is wrong, :func:`judge` refuses."""
        wrong.clear()
        return [take(each) for each in given]

    def take(given: RosParameter) -> RosParameter:
        """Return a parameter that rclpy lets pass: it says of a wrong one its type alone."""
        name = given.name
        if given.type_ == RosParameter.Type.NOT_SET or (
                name not in known and node.has_parameter(name)):
            return given
        try:
            return _ros_parameter(known[name], check(known[name], _as_typed(given, known[name])))
        except KeyError:
            wrong.append(InputError(f'unknown parameter {name!r}; the parameters are: '
                                    f'{", ".join(sorted(known))}'))
            return node.get_parameter('use_sim_time')
        except InputError as error:
            wrong.append(error)
            return node.get_parameter(name)

    def judge(given: list[RosParameter]) -> SetParametersResult:
        try:
            if wrong:
                raise wrong[0]
            if any(each.name == 'use_sim_time' and each.value for each in given):
                raise InputError('use_sim_time cannot be set while the node runs')
            checked = {each.name: check(known[each.name], _plain(each.value))
                       for each in given if each.name in known}
            if checked:
                prepare(checked)
                change(checked)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    for each in parameters:
        if not each.live:
            descriptor = _descriptor(each)
            descriptor.type = node.describe_parameter(each.name).type
            descriptor.read_only = True
            node.set_descriptor(each.name, descriptor)
    node.add_pre_set_parameters_callback(convert)
    node.add_on_set_parameters_callback(judge)


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    description = parameter.description
    if parameter.choices:
        description += f' One of: {", ".join(parameter.choices)}.'
    descriptor = ParameterDescriptor(
        name=parameter.name, description=description)
    if type(parameter.default) is int:
        descriptor.integer_range = [IntegerRange(
            from_value=int(parameter.lower), to_value=int(parameter.upper))]
    elif type(parameter.default) is float:
        descriptor.floating_point_range = [FloatingPointRange(
            from_value=float(parameter.lower), to_value=float(parameter.upper))]
    return descriptor


def _as_typed(given: RosParameter, parameter: Parameter) -> Any:
    """Return the value of a parameter; a text is what ``ros2 param`` makes of ``[1.0, 2]``."""
    value = _plain(given.value)
    if isinstance(value, str) and not isinstance(parameter.default, str):
        with suppress(InputError):  # the check says what is wrong with the text
            return parse_yaml(value, given.name)
    return value


def _ros_parameter(parameter: Parameter, value: Any) -> RosParameter:
    """Return a parameter of rclpy with a checked value."""
    if isinstance(parameter.default, list):
        return RosParameter(parameter.name, _NUMBERS, value)
    return RosParameter(parameter.name, value=value)


def _plain(value: Any) -> Any:
    """Return a list where rclpy has an array; it has None where an empty list is given."""
    if value is None:
        return []
    return list(value) if hasattr(value, '__len__') and not isinstance(value, str) else value
