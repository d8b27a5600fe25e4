"""The executable ``sim_node``: the node ``ur5_sim``, torques in, states out."""

from collections.abc import Sequence

from ur5_ros.nodes.ros.start import execute


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    execute('sim_node', 'The simulator: takes joint torques on /joint_command, publishes '
            '/joint_states.',
            ['SIM_PARAMETERS'], 'sim.node:SimNode', arguments)


if __name__ == '__main__':
    main()
