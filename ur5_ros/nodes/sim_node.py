"""The executable ``sim_node``: the node ``ur5_sim``, torques in, states out."""

import sys
from collections.abc import Sequence

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.start import asks_for_help, begin_start


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    if asks_for_help(sys.argv if arguments is None else arguments):
        from ur5_ros.config.parameters import SIM_PARAMETERS
        from ur5_ros.nodes.ros.usage import usage
        print(usage('sim_node', 'The simulator: takes joint torques on /joint_command, publishes '
                    '/joint_states.',
                    SIM_PARAMETERS))
        return
    stop = begin_start()
    require_environment(arguments)
    from ur5_ros.nodes.ros.process import run_node
    from ur5_ros.nodes.sim.node import SimNode
    run_node(SimNode, stop, arguments)


if __name__ == '__main__':
    main()
