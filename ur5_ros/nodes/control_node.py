"""The executable ``control_node``: the node ``ur5_control``, states in, computed torque out."""

from ur5_ros.nodes.ros.start import executable

main = executable(
    'control_node', 'The controller: takes /joint_states, publishes torques on /joint_command.',
    ['CONTROL_PARAMETERS'], 'control.node:ControlNode')

if __name__ == '__main__':
    main()
