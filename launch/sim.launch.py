"""The simulator alone: an arm that waits for torques."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    SetEnvironmentVariable,
    Shutdown,
    UnsetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from ur5_ros.config import config_folder

CONFIG = Path(config_folder())


def value(name: str, kind: type) -> ParameterValue:
    """Return a launch argument as a node parameter of a type."""
    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, the loopback profile and the node."""
    arguments = [
        DeclareLaunchArgument('ur_type', default_value='ur5', description='As in ur_description.'),
        DeclareLaunchArgument('arm', default_value=LaunchConfiguration('ur_type'),
                              description='A name of config/arms or a YAML file.'),
        DeclareLaunchArgument('tf_prefix', default_value='',
                              description='Put before every joint and frame name.'),
        DeclareLaunchArgument('namespace', default_value='', description='Of the node.'),
        DeclareLaunchArgument('gui', default_value='false', description="PyBullet's window."),
        DeclareLaunchArgument('lockstep', default_value='true',
                              description='Time waits for the answer to each state.'),
        DeclareLaunchArgument('control_rate', default_value='1000', description='[Hz]'),
        DeclareLaunchArgument('physics_rate', default_value='1000',
                              description='[Hz]; a whole multiple of control_rate.'),
        DeclareLaunchArgument('realtime_factor', default_value='1.0',
                              description='Paced: 1.0 = wall clock, 0.0 = as fast as it goes.'),
        DeclareLaunchArgument('effort_convention', default_value='total',
                              choices=['total', 'gravity_excluded'],
                              description='What a commanded effort means.'),
        DeclareLaunchArgument('stop_after', default_value='0.0',
                              description='End after this simulated time [s]; 0.0 = never.'),
        DeclareLaunchArgument('bag', default_value='auto',
                              description="'auto', a folder, or '' for no bag."),
        DeclareLaunchArgument('params_file', default_value=str(CONFIG / 'sim.yaml'),
                              description='ROS parameters that the arguments do not set.'),
        DeclareLaunchArgument('loopback', default_value='true',
                              description='Keep every socket on 127.0.0.1.'),
    ]
    network = GroupAction(
        [SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE',
                                str(CONFIG / 'fastdds_loopback.xml')),
         UnsetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE')],
        scoped=False, condition=IfCondition(LaunchConfiguration('loopback')))
    simulator = Node(
        package='ur5_ros', executable='sim_node', name='ur5_sim',
        namespace=LaunchConfiguration('namespace'), output='screen', emulate_tty=True,
        parameters=[LaunchConfiguration('params_file'), {
            'arm': value('arm', str),
            'tf_prefix': value('tf_prefix', str),
            'gui': value('gui', bool),
            'lockstep': value('lockstep', bool),
            'control_rate': value('control_rate', int),
            'physics_rate': value('physics_rate', int),
            'realtime_factor': value('realtime_factor', float),
            'effort_convention': value('effort_convention', str),
            'stop_after': value('stop_after', float),
            'bag': value('bag', str),
        }],
        on_exit=Shutdown(reason='the simulator has ended'))
    return LaunchDescription([*arguments, network, simulator])
