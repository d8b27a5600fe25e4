"""The tag with which ros2_control commands the simulated arm through two topics."""

from ur5_ros.signals import JOINT_NAMES

#: A hardware component that reads one topic and writes another (ros-controls,
#: topic_based_hardware_interfaces). It compares a command with the measured effort and holds back
#: what differs by no more than the threshold: -1 lets every command through.
PLUGIN = 'joint_state_topic_hardware_interface/JointStateTopicSystem'
THRESHOLD = -1
STATES = ('position', 'velocity', 'effort')


def with_ros2_control(urdf: str, tf_prefix: str = '', states_topic: str = '/joint_states',
                      command_topic: str = '/joint_command') -> str:
    """Return a URDF with a ``ros2_control`` tag: six effort interfaces over two topics."""
    joints = ''.join(
        f'    <joint name="{tf_prefix}{name}">\n'
        '      <command_interface name="effort"/>\n'
        + ''.join(f'      <state_interface name="{each}"/>\n' for each in STATES)
        + '    </joint>\n' for name in JOINT_NAMES)
    tag = (
        f'  <ros2_control name="{tf_prefix}ur5_ros" type="system">\n'
        '    <hardware>\n'
        f'      <plugin>{PLUGIN}</plugin>\n'
        f'      <param name="joint_states_topic">{states_topic}</param>\n'
        f'      <param name="joint_commands_topic">{command_topic}</param>\n'
        f'      <param name="trigger_joint_command_threshold">{THRESHOLD}</param>\n'
        '    </hardware>\n'
        f'{joints}'
        '  </ros2_control>\n')
    return urdf.replace('</robot>', f'{tag}</robot>')
