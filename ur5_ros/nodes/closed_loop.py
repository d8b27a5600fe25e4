"""The executable ``closed_loop``: ``ur5_sim`` and ``ur5_control`` in one process."""

import sys
from collections.abc import Sequence

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.start import asks_for_help, begin_start


def main(arguments: Sequence[str] | None = None) -> None:
    """Run both nodes; ``arguments`` is the command line, program name first."""
    if asks_for_help(sys.argv if arguments is None else arguments):
        from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS
        from ur5_ros.nodes.ros.usage import usage
        print(usage('closed_loop', 'Simulator and controller in one process. A parameter goes to '
                    'the node that declares it; -p NODE:NAME:=VALUE goes to one.',
                    {each.name: each for each in (*SIM_PARAMETERS, *CONTROL_PARAMETERS)}.values()))
        return
    stop = begin_start()
    require_environment(arguments)
    from ur5_ros.nodes.composition import ComposedNodes
    from ur5_ros.nodes.ros.process import run_node
    run_node(ComposedNodes, stop, arguments)


if __name__ == '__main__':
    main()
