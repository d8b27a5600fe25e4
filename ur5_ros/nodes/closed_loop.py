"""The executable ``closed_loop``: ``ur5_sim`` and ``ur5_control`` in one process."""

from collections.abc import Sequence

from ur5_ros.nodes.ros.start import execute


def main(arguments: Sequence[str] | None = None) -> None:
    """Run both nodes; ``arguments`` is the command line, program name first."""
    execute('closed_loop', 'Simulator and controller in one process. A parameter goes to the '
            'node that declares it; -p NODE:NAME:=VALUE goes to one.',
            ['SIM_PARAMETERS', 'CONTROL_PARAMETERS'], 'composition:ComposedNodes', arguments)


if __name__ == '__main__':
    main()
