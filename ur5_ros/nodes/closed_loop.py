"""The executable ``closed_loop``: ``ur5_sim`` and ``ur5_control`` in one process."""

from collections.abc import Sequence

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.start import begin_start


def main(arguments: Sequence[str] | None = None) -> None:
    """Run both nodes; ``arguments`` is the command line, program name first."""
    stop = begin_start()
    require_environment(arguments)
    from ur5_ros.nodes.composition import ComposedNodes
    from ur5_ros.nodes.ros.process import run_node
    run_node(ComposedNodes, stop, arguments)


if __name__ == '__main__':
    main()
