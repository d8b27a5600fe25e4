"""The simulator alone: an arm that waits for torques."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import Shutdown
from launch_ros.actions import Node

from ur5_ros.config import config_folder
from ur5_ros.launcher.launch_arguments import Argument, given, node_name, parameter_files
from ur5_ros.launcher.launch_file import ARM, PREFIXES, describe

CONFIG = Path(config_folder())
ARGUMENTS = {
    **ARM, **PREFIXES,
    'ur_type': Argument('', 'As in ur_description; ur5 by default.'),
    'gui': Argument('', "PyBullet's window: true or false (the node's default).", 'boolean'),
    'lockstep': Argument('', 'Time waits for the answer to each state: true (the default of the '
                         'node) or false.', 'boolean'),
    'control_rate': Argument('', '[Hz]; 1000 by default of the node.', 'integer'),
    'physics_rate': Argument('', '[Hz]; a whole multiple of control_rate; the same by default.',
                             'integer'),
    'realtime_factor': Argument('', 'Paced: 1.0 (the default of the node) = wall clock, 0.0 = as '
                                'fast as it goes.', 'number'),
    'effort_convention': Argument('', 'What a commanded effort means: total (the default of the '
                                  'node) or gravity_excluded.',
                                  choices=('total', 'gravity_excluded')),
    'stop_after': Argument('', 'End after this simulated time [s]; 0.0 (the default of the node) '
                           '= never.', 'number'),
    'bag': Argument('', "'auto' (the default of the node), a folder, or 'none'.", 'bag'),
    'preset': Argument('', 'A set of parameters that the arguments and params_file do not set: '
                       'ur_torque_mode.', choices=('ur_torque_mode',)),
    'params_file': Argument('', 'ROS parameters that the arguments do not set.', 'file'),
}


def nodes(values: dict) -> list:
    """Return the node with the arguments that were given."""
    if 'control_rate' in values:
        values.setdefault('physics_rate', values['control_rate'])
    [files] = parameter_files(values, node_name(values.get('namespace', ''), 'ur5_sim'))
    if 'preset' in values:
        files = [str(CONFIG / 'presets' / f'{values["preset"]}.yaml'), *files]
    return [Node(
        package='ur5_ros', executable='sim_node', name='ur5_sim',
        namespace=values.get('namespace', ''), output='screen', emulate_tty=True,
        on_exit=Shutdown(reason='the simulator has ended'),
        parameters=[str(CONFIG / 'sim.yaml'), *files, given(values, (
            'arm', 'tf_prefix', 'gui', 'lockstep', 'control_rate', 'physics_rate',
            'realtime_factor', 'effort_convention', 'stop_after', 'bag'))])]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and what is made of them."""
    return describe(ARGUMENTS, nodes)
