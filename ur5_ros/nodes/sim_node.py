"""The executable ``sim_node``: the node ``ur5_sim``, torques in, states out."""

from collections.abc import Sequence

from ur5_ros.nodes.environment import require_environment
from ur5_ros.nodes.shutdown import StopRequest, hold_signals


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    hold_signals()  # the imports take longer than an impatient user waits
    require_environment(arguments)
    from ur5_ros.nodes.process import run_node
    from ur5_ros.nodes.simulator import Simulator
    stop = StopRequest()
    stop.listen()
    run_node(Simulator, stop, arguments)


if __name__ == '__main__':
    main()
