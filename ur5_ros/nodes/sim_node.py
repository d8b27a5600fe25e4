"""The executable ``sim_node``: the node ``ur5_sim``, torques in, states out."""

from ur5_ros.nodes.ros.start import executable

main = executable(
    'sim_node', 'The simulator: takes joint torques on /joint_command, publishes /joint_states.',
    ['SIM_PARAMETERS'], 'sim.node:SimNode')

if __name__ == '__main__':
    main()
