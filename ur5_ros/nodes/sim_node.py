"""The node ``ur5_sim``: torques in, states out, and nothing that the equations do not know."""

from collections.abc import Sequence
from typing import Any

from rclpy.node import Node

from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.folder import new_run_name
from ur5_ros.config import SIM_PARAMETERS, arm_text, read_yaml
from ur5_ros.errors import Refusal
from ur5_ros.nodes.diagnostics import EverySecond
from ur5_ros.nodes.lockstep import InterimGate, Lockstep
from ur5_ros.nodes.parameters import check_files, declare
from ur5_ros.nodes.process import DONE, LOSS, freeze_garbage, run_node
from ur5_ros.nodes.recording import Recording, run_of
from ur5_ros.nodes.shutdown import StopRequest
from ur5_ros.nodes.sim_inputs import SimInputs
from ur5_ros.nodes.sim_topics import SimOutputs
from ur5_ros.nodes.simulation import Simulation
from ur5_ros.nodes.topics import Topics, make_loop
from ur5_ros.sim.plant import plant_from_parameters
from ur5_ros.sim.urdf import urdf_text


class SimNode:
    """
    The simulator on its topics.

    Parameters
    ----------
    arguments : sequence of str
        Command line.
    stop : StopRequest
        Asks it to end.

    """

    def __init__(self, arguments: Sequence[str], stop: StopRequest) -> None:
        self.node = Node('ur5_sim')
        check_files(arguments, self.node.get_fully_qualified_name(), read_yaml)
        parameters = self.parameters = declare(self.node, SIM_PARAMETERS)
        if self.node.get_parameter('use_sim_time').value:
            raise Refusal('use_sim_time is true, but this node makes the time; leave it false')
        self._stop = stop
        self._logger = self.node.get_logger()
        self._run = run_of(parameters['bag'], new_run_name)
        plant = plant_from_parameters(parameters)
        self.recording = Recording(parameters['bag'], 'sim', parameters['max_bagfile_duration'],
                                   parameters['max_bagfile_size'])
        loop = make_loop(self.node, parameters['hot_loop'])
        topics = Topics(self.node, loop, self.recording)
        self.outputs = SimOutputs(self.node, topics, self.recording, parameters, plant.arm.name)
        self.simulation = Simulation(plant, self.outputs, self._logger, parameters)
        self.inputs = SimInputs(loop, topics, self.recording, self.simulation,
                                InterimGate(parameters['lockstep_timeout']), parameters)
        self.recording.begin(self._run, describe(
            'sim', self._run, plant.arm.name, arm_text(parameters['arm']), parameters,
            topics.names, fingerprint()))
        self.outputs.introduce(self._run, urdf_text(plant.arm, parameters['tf_prefix']))
        self._pace = Lockstep(self.simulation, self.inputs)
        self._every_second = EverySecond()
        loop.start()
        self._loop = loop

    def run(self) -> int:
        """Simulate until the end; return the exit code."""
        where = self.recording.folder or 'nowhere'
        self._logger.info(f'run {self._run}, recorded in {where}')
        freeze_garbage()
        simulation, pace, every_second = self.simulation, self._pace, self._every_second
        pace.begin()
        while not self._stop.reason:
            pace.turn()
            if simulation.finished:
                self._stop.ask('stop_after')
            if every_second.due():
                self._report()
        return self._end()

    def counters(self) -> dict[str, Any]:
        """Return what was counted so far."""
        return {**self.simulation.plant.counters, **self.inputs.refusals.counts}

    def _report(self) -> None:
        values = self.counters() | {'run': self._run, 'bag_lost': self.recording.lost}
        self.outputs.diagnostics(self.simulation.plant.stamp, 0, 'running', values)

    def _end(self) -> int:
        self.inputs.requests.close()
        if self._stop.reason != 'stop_after':
            self.simulation.rest()
        self._report()
        self._loop.close()
        self.recording.end({
            'reason': self._stop.reason, 'run': self._run,
            'hashes': {'joint_states': self.outputs.hash.hexdigest(),
                       'joint_command': self.inputs.hash.hexdigest()},
            'periods': self.outputs.hash.count, 'counters': self.counters(),
        })
        self.simulation.plant.close()
        lost, failure = self.recording.lost, self.recording.failure
        if lost or failure:
            self._logger.error(f'{lost} messages are in no bag: {failure or "too many at once"}')
        self._logger.info(f'ends at {self.simulation.plant.stamp * 1e-9:.3f} s: '
                          f'{self._stop.reason}')
        return LOSS if lost or failure else DONE


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the node; the console script ``sim_node``."""
    run_node(SimNode, arguments)


if __name__ == '__main__':
    main()
