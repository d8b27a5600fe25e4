"""RViz and the transforms it needs, for a simulator that runs already or a bag that is played."""

from pathlib import Path

from launch import LaunchDescription
from launch_ros.actions import Node

from ur5_ros.config import config_folder, load_arm
from ur5_ros.launcher.launch_arguments import (
    Argument,
    node_name,
    parameter_files,
    require_packages,
)
from ur5_ros.launcher.launch_file import ARM, PREFIXES, describe
from ur5_ros.sim.urdf import urdf_text

CONFIG = Path(config_folder())
ARGUMENTS = {
    **ARM, **PREFIXES,
    'launch_rviz': Argument('true', 'false: the transforms alone.', 'boolean'),
    'rviz_config_file': Argument(str(CONFIG / 'layouts' / 'ur5.rviz'), 'Layout of RViz.', 'file'),
    'params_file': Argument('', 'ROS parameters of robot_state_publisher.', 'file'),
    'use_sim_time': Argument('true', "Follow the simulator's /clock.", 'boolean'),
}


def nodes(values: dict) -> list:
    """Return robot_state_publisher with the URDF of the arm, and RViz."""
    namespace, prefix = values.get('namespace', ''), values.get('tf_prefix', '')
    use_sim_time = {'use_sim_time': values['use_sim_time']}
    require_packages('robot_state_publisher')
    [files] = parameter_files(values, node_name(namespace, 'robot_state_publisher'))
    started = [Node(
        package='robot_state_publisher', executable='robot_state_publisher', namespace=namespace,
        output='screen', parameters=[*files, use_sim_time, {
            'robot_description': urdf_text(load_arm(values['arm']), prefix)}])]
    if values['launch_rviz']:
        require_packages('rviz2')
        started.append(Node(
            package='rviz2', executable='rviz2', namespace=namespace, output='screen',
            arguments=['-d', values['rviz_config_file'], '-f', f'{prefix}base_link'],
            parameters=[use_sim_time]))
    return started


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and what is made of them."""
    return describe(ARGUMENTS, nodes)
