"""The executable ``control_node``: the node ``ur5_control``, states in, computed torque out."""

from collections.abc import Sequence

from ur5_ros.nodes.ros.start import execute


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; ``arguments`` is the command line, program name first."""
    execute('control_node', 'The controller: takes /joint_states, publishes torques on '
            '/joint_command.',
            ['CONTROL_PARAMETERS'], 'control.node:ControlNode', arguments)


if __name__ == '__main__':
    main()
