"""What the launch files share; the packages launch and launch_ros are imported here alone."""

from collections.abc import Callable, Mapping
from typing import Any

from launch import LaunchContext, LaunchDescription  # type: ignore[attr-defined]  # our folder launch
from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    SetEnvironmentVariable,
    UnsetEnvironmentVariable,
)
from launch.substitutions import LaunchConfiguration

from ur5_ros.config import config_folder
from ur5_ros.launcher.launch_arguments import Argument, read_arguments

#: Which arm, in every launch file.
ARM = {
    'ur_type': Argument('ur5', 'As in ur_description.'),
    'arm': Argument(LaunchConfiguration('ur_type'), 'A name of config/arms or a YAML file.'),
}
#: What stands before the names of joints, frames and nodes.
PREFIXES = {
    'tf_prefix': Argument('', 'Put before every joint and frame name.'),
    'namespace': Argument('', 'Of the nodes.'),
}
_NETWORK = {'loopback': Argument('true', 'Keep every socket on 127.0.0.1.', 'boolean')}


def describe(
    arguments: Mapping[str, Argument], nodes: Callable[[dict[str, Any]], list],
) -> LaunchDescription:
    """
    Return a launch description.

    ``arguments``: what the launch file takes, ``loopback`` besides.  Returned: the declared
    arguments, the environment and what ``nodes`` returns.  Everything is checked before the first
    process is started.
    """
    arguments = {**arguments, **_NETWORK}

    def actions(context: LaunchContext) -> list:
        values = read_arguments(arguments, {name: LaunchConfiguration(name).perform(context)
                                            for name in arguments})
        return [*_network(values['loopback']), *nodes(values)]

    declared = [DeclareLaunchArgument(name, default_value=each.default,
                                      description=each.description)
                for name, each in arguments.items()]
    return LaunchDescription([*declared, OpaqueFunction(function=actions)])


def _network(loopback: bool) -> list:
    """Return what keeps every socket on the loopback interface, if asked."""
    if not loopback:
        return []
    return [SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE',
                                   str(config_folder() / 'fastdds_loopback.xml')),
            UnsetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE')]
