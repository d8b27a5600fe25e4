"""Both nodes on an experiment: the simulator starts where the experiment wants it."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
    UnsetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from ur5_ros.config import config_folder, load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import initial_positions

CONFIG = Path(config_folder())
HERE = Path(__file__).resolve().parent
ARGUMENTS = {
    'ur_type': ('ur5', 'As in ur_description.'),
    'arm': (LaunchConfiguration('ur_type'), 'The simulated arm: a name of config/arms or a file.'),
    'control_arm': (LaunchConfiguration('arm'), 'Arm of the law; another one is the robustness '
                    'experiment.'),
    'experiment': ('kebria_fig11', 'A name of config/experiments or a file.'),
    'tf_prefix': ('', 'Put before every joint and frame name.'),
    'namespace': ('', 'Of both nodes.'),
    'gui': ('false', "PyBullet's window."),
    'lockstep': ('true', 'Time waits for the answer to each state.'),
    'control_rate': ('1000', '[Hz]'),
    'realtime_factor': ('1.0', 'Paced runs: 1.0 = wall clock, 0.0 = as fast as it goes.'),
    'effort_convention': ('total', 'total or gravity_excluded, for both nodes.'),
    'bag': ('auto', "Run folder of both bags; 'auto' names one, '' makes none."),
    'launch_rviz': ('false', 'Show the arm in RViz.'),
    'use_sim_time': ('true', 'Of RViz and robot_state_publisher.'),
    'loopback': ('true', 'Keep every socket on 127.0.0.1.'),
}


def nodes(context: LaunchContext) -> list:
    """Return the two nodes with the arguments as typed by the user."""
    said = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    experiment, arm = load_experiment(said['experiment']), load_arm(said['control_arm'])
    shared = {
        'tf_prefix': said['tf_prefix'],
        'effort_convention': said['effort_convention'],
    }
    bags = {node: said['bag'] if said['bag'] in ('', 'auto') else f'{said["bag"]}/{node}'
            for node in ('sim', 'control')}
    simulator = Node(
        package='ur5_ros', executable='sim_node', name='ur5_sim', namespace=said['namespace'],
        output='screen', emulate_tty=True, on_exit=Shutdown(reason='the simulator has ended'),
        parameters=[str(CONFIG / 'sim.yaml'), shared | {
            'arm': said['arm'],
            'bag': bags['sim'],
            'gui': said['gui'].lower() == 'true',
            'lockstep': said['lockstep'].lower() == 'true',
            'control_rate': int(said['control_rate']),
            'physics_rate': int(said['control_rate']),
            'realtime_factor': float(said['realtime_factor']),
            'initial_positions': [float(q) for q in initial_positions(experiment, arm)],
            'stop_after': float(experiment.duration),
        }])
    controller = Node(
        package='ur5_ros', executable='control_node', name='ur5_control',
        namespace=said['namespace'], output='screen', emulate_tty=True,
        parameters=[str(CONFIG / 'control.yaml'), shared | {
            'arm': said['control_arm'],
            'bag': bags['control'],
            'experiment': said['experiment'],
            'autostart': True,
        }])
    return [simulator, controller]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, the loopback profile, the nodes and RViz if wanted."""
    arguments = [DeclareLaunchArgument(name, default_value=default, description=description)
                 for name, (default, description) in ARGUMENTS.items()]
    network = GroupAction(
        [SetEnvironmentVariable('FASTRTPS_DEFAULT_PROFILES_FILE',
                                str(CONFIG / 'fastdds_loopback.xml')),
         UnsetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE')],
        scoped=False, condition=IfCondition(LaunchConfiguration('loopback')))
    rviz = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(HERE / 'rviz.launch.py')),
        launch_arguments={name: LaunchConfiguration(name) for name in (
            'arm', 'tf_prefix', 'namespace', 'use_sim_time', 'loopback')}.items(),
        condition=IfCondition(LaunchConfiguration('launch_rviz')))
    return LaunchDescription([*arguments, network, OpaqueFunction(function=nodes), rviz])
