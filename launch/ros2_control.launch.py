"""The simulator under ros2_control: its controllers command the arm through a topic."""

from launch import LaunchDescription
from launch.actions import Shutdown
from launch_ros.actions import Node

from ur5_ros.config import config_folder, load_arm
from ur5_ros.launcher.launch_arguments import (
    Argument,
    given,
    node_name,
    parameter_files,
    require_packages,
)
from ur5_ros.launcher.launch_file import ARM, describe
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.sim.urdf_ros2_control import with_ros2_control

CONFIG = config_folder()
#: The controller manager reads its URDF here: /robot_description is the simulator's own.
DESCRIPTION = '/tagged_description'
ARGUMENTS = {
    **ARM,
    'gui': Argument('', "PyBullet's window: true or false (the default of the node).", 'boolean'),
    'control_rate': Argument('500', 'States a second [Hz]; controllers.yaml has the same.',
                             'integer'),
    'controller': Argument('arm_effort_controller', 'Which controller is activated.',
                           choices=('arm_effort_controller', 'arm_trajectory_controller')),
    'controllers_file': Argument(str(CONFIG / 'controllers.yaml'), 'Parameters of the controller '
                                 'manager and its controllers.', 'file'),
    'repeated_command_timeout': Argument('', 'The same torque for longer than this [s] is no '
                                         'command; 0 (the default of the node) = for ever.',
                                         'number'),
    'bag': Argument('', "'auto' (the default of the node), a folder, or 'none'.", 'bag'),
    'params_file': Argument('', 'ROS parameters of the simulator.', 'file'),
}


def nodes(values: dict) -> list:
    """Return the simulator, the URDF with the tag, the controller manager and a controller."""
    require_packages('controller_manager', 'joint_state_topic_hardware_interface',
                     'robot_state_publisher')
    [files] = parameter_files(values, node_name('', 'ur5_sim'))
    clock = {'use_sim_time': True}
    description = with_ros2_control(urdf_text(load_arm(values['arm'])))
    simulator = Node(
        package='ur5_ros', executable='sim_node', name='ur5_sim', output='screen',
        emulate_tty=True, on_exit=Shutdown(reason='the simulator has ended'),
        parameters=[str(CONFIG / 'sim.yaml'), *files, given(values, (
            'arm', 'gui', 'control_rate', 'repeated_command_timeout', 'bag')) | {
                'physics_rate': values['control_rate'], 'lockstep': False,
                'effort_convention': 'gravity_excluded'}])
    transforms = Node(
        package='robot_state_publisher', executable='robot_state_publisher', output='screen',
        parameters=[clock, {'robot_description': description}],
        remappings=[('robot_description', DESCRIPTION)])
    manager = Node(
        package='controller_manager', executable='ros2_control_node', output='screen',
        parameters=[values['controllers_file']],
        # on the command line, so that the hardware component's own node has it too
        ros_arguments=['-p', 'use_sim_time:=true'],
        remappings=[('robot_description', DESCRIPTION)],
        on_exit=Shutdown(reason='the controller manager has ended'))
    controller = Node(
        package='controller_manager', executable='spawner', output='screen',
        arguments=[values['controller'], '--param-file', values['controllers_file']],
        parameters=[clock])
    return [simulator, transforms, manager, controller]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and what is made of them."""
    return describe(ARGUMENTS, nodes)
