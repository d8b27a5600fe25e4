"""The executable ``control_node``: the node ``ur5_control``, states in, computed torque out."""

import sys
from collections.abc import Sequence

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.start import asks_for_help, begin_start


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    if asks_for_help(sys.argv if arguments is None else arguments):
        from ur5_ros.config.parameters import CONTROL_PARAMETERS
        from ur5_ros.nodes.ros.usage import usage
        print(usage('control_node', 'The controller: takes /joint_states, publishes torques on '
                    '/joint_command.',
                    CONTROL_PARAMETERS))
        return
    stop = begin_start()
    require_environment(arguments)
    from ur5_ros.nodes.control.node import ControlNode
    from ur5_ros.nodes.ros.process import run_node
    run_node(ControlNode, stop, arguments)


if __name__ == '__main__':
    main()
