"""Both nodes in one process, taking turns in one thread: ROS calls it composition."""

from pathlib import Path

from rclpy.node import Node

from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS
from ur5_ros.config.parameter_files import require_sections
from ur5_ros.config.topics import CONTROL_NODE, SIM_NODE
from ur5_ros.errors import InputError
from ur5_ros.nodes.control.node import ControlNode
from ur5_ros.nodes.ros.recording import NO_BAG
from ur5_ros.nodes.ros.shared_wait import SharedLoop, SharedWait
from ur5_ros.nodes.ros.shutdown import StopRequest
from ur5_ros.nodes.sim.node import SimNode

_NAMES = {SIM_NODE: {each.name for each in SIM_PARAMETERS},
          CONTROL_NODE: {each.name for each in CONTROL_PARAMETERS}}


class ComposedNodes:
    """
    The simulator and the controller with the topics that they have in two processes.

    In lockstep only one of them works at a time, so that one thread loses nothing and spares both
    the wait for the other to be woken.

    """

    def __init__(self, files: list[Path], stop: StopRequest) -> None:
        self._wait = SharedWait()
        given = _given_to_both(files)
        # the controller first: it opens no bag before the simulator has named the run
        self._control = ControlNode([], stop, self._loop, given & _NAMES[SIM_NODE])
        self._sim = SimNode([], stop, self._loop, given & _NAMES[CONTROL_NODE])
        self._control.cycle.take_rate(self._sim.parameters.control_rate)

    def begin(self) -> None:
        """Send state 1."""
        self._control.begin()
        self._sim.begin()

    def turn(self) -> None:
        """Let the simulator take its turn, then the controller; wait if neither had work."""
        busy = self._sim.turn()
        busy = self._control.turn() or busy
        if self._sim.second_simulator:
            raise InputError(f'{self._sim.second_simulator} publishes joint_states in this '
                             'namespace too; end it, or choose another: -r __ns:=/other')
        if not busy:
            self._wait.wait()

    def end(self, reason: str) -> int:
        """End the simulator, answer its last state, end the controller; return the exit code."""
        code = self._sim.end(reason)
        while self._control.turn():
            pass
        return max(code, self._control.end(reason))

    def _loop(self, node: Node, kind: str) -> SharedLoop:
        if kind != 'wait_set':
            raise InputError(f'hot_loop {kind!r} of {node.get_name()}: nodes in one process share '
                             'a wait set; leave it wait_set, or start sim_node and control_node')
        return self._wait.loop(node)


def _given_to_both(files: list[Path]) -> set[str]:
    """Return the names of the parameters that are given to no node in particular."""
    probe = Node('ur5_composed', enable_rosout=False, start_parameter_services=False)
    try:
        namespace = probe.get_namespace().rstrip('/')
        require_sections(files, *(f'{namespace}/{name}' for name in _NAMES))
        given = probe._parameter_overrides
        bag = given['bag'].value if 'bag' in given else ''
        if bag not in (*NO_BAG, 'auto'):
            raise InputError(f'bag {bag!r} is one folder for two nodes; give -p ur5_sim:bag:='
                             f'{bag}/sim -p ur5_control:bag:={bag}/control')
        return set(given)
    finally:
        probe.destroy_node()
