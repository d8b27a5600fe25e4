"""The executable ``sim_node``: the node ``ur5_sim``, torques in, states out."""

from collections.abc import Sequence

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.start import begin_start


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    stop = begin_start()
    require_environment(arguments)
    from ur5_ros.nodes.ros.process import run_node
    from ur5_ros.nodes.sim.node import SimNode
    run_node(SimNode, stop, arguments)


if __name__ == '__main__':
    main()
