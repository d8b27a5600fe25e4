"""RViz and the transforms it needs, for a simulator that runs already or a bag that is played."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    OpaqueFunction,
    SetEnvironmentVariable,
    UnsetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from ur5_ros.config import config_folder, load_arm
from ur5_ros.sim.urdf import urdf_text

CONFIG = Path(config_folder())
ARGUMENTS = {
    'ur_type': ('ur5', 'As in ur_description.'),
    'arm': (LaunchConfiguration('ur_type'), 'A name of config/arms or a YAML file.'),
    'tf_prefix': ('', 'Put before every joint and frame name.'),
    'namespace': ('', 'Of the nodes.'),
    'launch_rviz': ('true', 'false: the transforms alone.'),
    'rviz_config_file': (str(CONFIG / 'layouts' / 'ur5.rviz'), 'Layout of RViz.'),
    'use_sim_time': ('true', "Follow the simulator's /clock."),
    'loopback': ('true', 'Keep every socket on 127.0.0.1.'),
}


def nodes(context: LaunchContext) -> list:
    """Return robot_state_publisher with the URDF of the arm, and RViz."""
    said = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    use_sim_time = {'use_sim_time': said['use_sim_time'].lower() == 'true'}
    description = urdf_text(load_arm(said['arm']), said['tf_prefix'])
    transforms = Node(
        package='robot_state_publisher', executable='robot_state_publisher',
        namespace=said['namespace'], output='screen',
        parameters=[use_sim_time, {'robot_description': description}])
    rviz = Node(
        package='rviz2', executable='rviz2', namespace=said['namespace'], output='screen',
        arguments=['-d', said['rviz_config_file'], '-f', f'{said["tf_prefix"]}base_link'],
        parameters=[use_sim_time], condition=IfCondition(LaunchConfiguration('launch_rviz')))
    return [transforms, rviz]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, the loopback profile and the two nodes."""
    arguments = [DeclareLaunchArgument(name, default_value=default, description=description)
                 for name, (default, description) in ARGUMENTS.items()]
    network = GroupAction(
        [SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE',
                                str(CONFIG / 'fastdds_loopback.xml')),
         UnsetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE')],
        scoped=False, condition=IfCondition(LaunchConfiguration('loopback')))
    return LaunchDescription([*arguments, network, OpaqueFunction(function=nodes)])
