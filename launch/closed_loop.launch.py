"""Both nodes on an experiment: the simulator starts where the experiment begins."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from ur5_ros.config import config_folder, load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import initial_positions
from ur5_ros.launcher.launch_arguments import Argument, given, node_name, parameter_files
from ur5_ros.launcher.launch_file import ARM, PREFIXES, describe
from ur5_ros.model.parameters import ArmParameters

CONFIG = Path(config_folder())
HERE = Path(__file__).resolve().parent
ARGUMENTS = {
    **ARM, **PREFIXES,
    'control_arm': Argument(LaunchConfiguration('arm'), 'Arm of the law; another one is the '
                            'robustness experiment.'),
    'experiment': Argument('kebria_fig11', 'A name of config/experiments or a file; none = no '
                           'experiment and no end: the arm is held until it has a target.'),
    'gui': Argument('', "PyBullet's window: true or false (the default of the node).", 'boolean'),
    'lockstep': Argument('', 'Time waits for the answer to each state: true (the default of the '
                         'node) or false.', 'boolean'),
    'control_rate': Argument('', '[Hz]; 1000 by default of the node.', 'integer'),
    'realtime_factor': Argument('', 'Paced: 1.0 (the default of the node) = wall clock, 0.0 = as '
                                'fast as it goes.', 'number'),
    'effort_convention': Argument('', 'For both nodes: total (their default) or '
                                  'gravity_excluded.', choices=('total', 'gravity_excluded')),
    'bag': Argument('', "Run folder of both bags; 'auto' (the default) names one, 'none' makes "
                    'none.', 'bag'),
    'params_file': Argument('', 'ROS parameters of one node or both, which the arguments do not '
                            'set.', 'file'),
    'composed': Argument('false', 'Both nodes in one process.', 'boolean'),
    'launch_rviz': Argument('false', 'Show the arm in RViz.', 'boolean'),
    'use_sim_time': Argument('true', 'Of RViz and robot_state_publisher.', 'boolean'),
}


def nodes(values: dict) -> list:
    """Return RViz if it is to be shown, and the two nodes."""
    start, motion = of_experiment(values['experiment'], load_arm(values['control_arm']))
    if 'control_rate' in values:
        values['physics_rate'] = values['control_rate']
    folder = values.get('bag')
    bags = {node: {} if folder is None else
            {'bag': folder if folder in ('none', 'auto') else f'{folder}/{node}'}
            for node in ('sim', 'control')}
    namespace = values.get('namespace', '')
    sim_files, control_files = parameter_files(
        values, node_name(namespace, 'ur5_sim'), node_name(namespace, 'ur5_control'))
    sim = given(values, (
        'tf_prefix', 'gui', 'lockstep', 'control_rate', 'physics_rate', 'realtime_factor',
        'effort_convention')) | start
    control = given(values, ('tf_prefix', 'effort_convention')) | motion
    own = {'ur5_sim': {'arm': values['arm']} | bags['sim'],
           'ur5_control': {'arm': values['control_arm']} | bags['control']}
    # RViz first: a package that is missing ends the launch before a node is started
    shown = rviz(values['launch_rviz'])
    if values['composed']:
        return [*shown, Node(
            package='ur5_ros', executable='closed_loop', namespace=namespace, output='screen',
            emulate_tty=True, on_exit=Shutdown(reason='both nodes have ended'),
            parameters=[*{*sim_files, *control_files}, sim | control],
            ros_arguments=[word for node, each in own.items() for name, value in each.items()
                           for word in ('-p', f'{node}:{name}:={value}')])]
    simulator = Node(
        package='ur5_ros', executable='sim_node', name='ur5_sim', namespace=namespace,
        output='screen', emulate_tty=True, on_exit=Shutdown(reason='the simulator has ended'),
        parameters=[str(CONFIG / 'sim.yaml'), *sim_files, sim | own['ur5_sim']])
    controller = Node(
        package='ur5_ros', executable='control_node', name='ur5_control', namespace=namespace,
        output='screen', emulate_tty=True, on_exit=Shutdown(reason='the controller has ended'),
        parameters=[str(CONFIG / 'control.yaml'), *control_files, control | own['ur5_control']])
    return [*shown, simulator, controller]


def of_experiment(name: str, arm: ArmParameters) -> tuple[dict, dict]:
    """Return the parameters that an experiment gives the simulator and the controller."""
    if name == 'none':
        return {}, {}
    experiment = load_experiment(name)
    start = [float(q) for q in initial_positions(experiment, arm)]
    return ({'initial_positions': start, 'stop_after': float(experiment.duration)},
            {'experiment': name, 'autostart': True})


def rviz(shown: bool) -> list:
    """Return what shows the arm, if asked."""
    if not shown:
        return []
    return [IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(HERE / 'rviz.launch.py')),
        launch_arguments=({'params_file': ''} | {name: LaunchConfiguration(name) for name in (
            'arm', 'tf_prefix', 'namespace', 'use_sim_time', 'loopback')}).items())]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and what is made of them."""
    return describe(ARGUMENTS, nodes)
