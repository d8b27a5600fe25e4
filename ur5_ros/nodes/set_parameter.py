"""One parameter of a running node, set over ROS: ``ur5 set`` where ros2cli is not installed."""

import time

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions

from ur5_ros.config.parameters import nearest
from ur5_ros.config.strict_yaml import parse_yaml
from ur5_ros.errors import InputError

#: Wall-clock time that the node gets to be found, and to answer [s].
TIMEOUT = 5.0


def set_parameter(node_name: str, name: str, text: str, timeout: float = TIMEOUT) -> str:
    """
    Set a parameter of a node and return the value as it was sent.

    ``node_name``: such as ``/ur5_sim``; the slash may be left out; ``timeout``: wall-clock time to
    find the node, and to hear its answer [s].
    """
    value = _value(name, text)
    node_name = '/' + node_name.removeprefix('/')
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node('ur5_set', start_parameter_services=False)
    try:
        client = AsyncParameterClient(node, node_name)
        if not client.wait_for_services(timeout):
            raise InputError(f'no node {node_name} answers within {timeout:g} s; '
                             f'{_nodes(node)}')
        known = client.list_parameters([], 0)
        rclpy.spin_until_future_complete(node, known, timeout_sec=timeout)
        names = sorted(known.result().result.names) if known.done() else []
        if names and name not in names:
            raise InputError(f'{node_name} has no parameter {name!r}; {nearest(name, names)}')
        future = client.set_parameters([Parameter(name, value=value)])
        rclpy.spin_until_future_complete(node, future, timeout_sec=timeout)
        if not future.done():
            raise InputError(f'{node_name} does not answer within {timeout:g} s')
        result = future.result().results[0]
        if not result.successful:
            raise InputError(f'{node_name} refuses {name}: {result.reason}')
        return str(value)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _value(name: str, text: str) -> object:
    value = parse_yaml(text, name)
    if isinstance(value, list) and value and all(
            isinstance(each, int | float) and not isinstance(each, bool) for each in value):
        return [float(each) for each in value]
    if value is None or isinstance(value, dict | list) and not value:
        raise InputError(f'{name}: {text!r} is not a value; give a number, true, a word or [1, 2]')
    return value


def _nodes(node: Node) -> str:
    """Return which nodes there are, once discovery had its time."""
    time.sleep(0.5)
    own = node.get_fully_qualified_name()
    found = sorted('/'.join((space.rstrip('/'), name))
                   for name, space in node.get_node_names_and_namespaces())
    others = [each for each in found if each != own]
    return f'there are: {", ".join(others)}' if others else 'there are none in this domain'
