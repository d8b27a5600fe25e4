"""Commands on running nodes: set."""

from ur5_ros.cli.exit_codes import SUCCESS


def set_parameter(node: str, name: str, value: str) -> int:
    """Set a parameter of a running node; see ``ur5 set --help``."""
    from ur5_ros.nodes.ros.environment import check_environment
    check_environment()  # the middleware is loaded with the next import
    from ur5_ros.nodes.set_parameter import set_parameter as send
    print(f'{node} {name}: {send(node, name, value)}')
    return SUCCESS
