"""The executable ``closed_loop``: ``ur5_sim`` and ``ur5_control`` in one process."""

from ur5_ros.nodes.ros.start import executable

main = executable(
    'closed_loop', 'Simulator and controller in one process. A parameter goes to the node that '
    'declares it; -p NODE:NAME:=VALUE goes to one.',
    ['SIM_PARAMETERS', 'CONTROL_PARAMETERS'], 'composition:ComposedNodes')

if __name__ == '__main__':
    main()
