"""The lockstep period in which nothing happens but a step: from bytes to bytes, no arrays."""

from struct import Struct

from ur5_ros.cdr.fixed_messages import FixedJointState, encode_stamp
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.sim.command_gate import CommandGate

_SIX = Struct('<6d')
_TWELVE = Struct('<12d')
_STAMP = Struct('<iI')


class PlainPeriod:
    """
    The short way from a command's bytes to the next state's; equal bits to the long way.

    Parameters
    ----------
    simulation : Simulation
        The plant on its topics.
    gate : CommandGate
        Which command is waited for.
    layout : FixedJointState
        That of the commands it takes.

    """

    def __init__(self, simulation: Simulation, gate: CommandGate, layout: FixedJointState) -> None:
        self._simulation = simulation
        self._gate = gate
        self._matches = layout.matches
        self._at = layout.effort.start
        self._effort = layout.effort

    def fits(self, data: bytes) -> tuple[float, ...] | None:
        """Return the torques of a command that acts at once and as it is [N m], else None."""
        if self._simulation.paused or not self._matches(data):
            return None
        seconds, nanoseconds = _STAMP.unpack_from(data, 4)
        if not self._gate.expects(seconds * 1_000_000_000 + nanoseconds):
            return None
        tau = _SIX.unpack_from(data, self._at)
        return tau if self._simulation.plant.takes(tau) else None

    def step(self, tau: tuple[float, ...], data: bytes) -> bool:
        """Take the step and send its state; False if a limit asks for the long way."""
        plant = self._simulation.plant
        values = plant.step_plainly(tau)
        if values is None:
            return False
        packed = _TWELVE.pack(*values)
        self._simulation.outputs.state_bytes(
            encode_stamp(plant.stamp), packed[:48], packed[48:], data[self._effort])
        self._gate.stepped(plant.k)
        return True
