"""The node ``ur5_sim``: torques in, states out, every influence on the arm recorded."""

import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from rclpy.node import Node

from ur5_ros.bag.description import describe
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.bag.run_folders import new_run_name
from ur5_ros.config import arm_text
from ur5_ros.config.arms import ASSUMED, arms_with_assumed_armature
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.topics import SIM_NODE, SIM_TOPICS, WORLD_TOPICS
from ur5_ros.config.worlds import world_text
from ur5_ros.errors import InputError
from ur5_ros.model.frames import wrench_in_base
from ur5_ros.nodes.ros.background_executor import poll_graph
from ur5_ros.nodes.ros.diagnostics import WAITING_PERIOD, EverySecond
from ur5_ros.nodes.ros.parameters import open_node, update
from ur5_ros.nodes.ros.process import compiling, end_node
from ur5_ros.nodes.ros.realtime import use_realtime
from ur5_ros.nodes.ros.recording import Recording, run_of
from ur5_ros.nodes.ros.shutdown import StopRequest
from ur5_ros.nodes.ros.topics import Loop, Topics, make_loop
from ur5_ros.nodes.sim.diagnostics import check_publishers, counters, report
from ur5_ros.nodes.sim.inputs import SimInputs
from ur5_ros.nodes.sim.loop import SimLoop
from ur5_ros.nodes.sim.services import StepQueue, create_services
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.nodes.sim.topics import SimOutputs
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.integrator import kernels_seem_cached, prepare_kernels
from ur5_ros.sim.lockstep_gate import command_gate
from ur5_ros.sim.plant import Plant, plant_from_parameters
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.throttle import Throttle


class SimNode:
    """
    The simulator on its topics.

    ``loop``: makes the loop that its messages go through; by default as ``hot_loop`` names it.

    """

    def __init__(
        self, files: list[Path], stop: StopRequest,
        loop: Callable[[Node, str], Loop] = make_loop, elsewhere: Collection[str] = (),
    ) -> None:
        self.node, parameters = open_node(SIM_NODE, files, SimParameters, elsewhere)
        if self.node.get_parameter('use_sim_time').value:
            raise InputError('use_sim_time is true, but this node makes the time; leave it false')
        self.stop = stop
        self.logger = self.node.get_logger()
        self.run_name = run_of(parameters.bag, new_run_name)
        with compiling(self.logger):
            plant = plant_from_parameters(parameters)
            # wall time goes on while anything is loaded later; in lockstep it may be, not compiled
            if not (parameters.lockstep and kernels_seem_cached()):
                prepare_kernels()
                wrench_in_base([0.0] * 3, [0.0] * 3, 'tool0', plant.truth.q, plant.arm)
        parameters = self.parameters = update(self.node, parameters, plant.parameters)
        self.recording = Recording(parameters.bag, 'sim', parameters.max_bagfile_duration,
                                   parameters.max_bagfile_size)
        self._loop = loop(self.node, parameters.hot_loop)
        topics = self.topics = Topics(self.node, self._loop, self.recording,
                                      (*SIM_TOPICS, *WORLD_TOPICS))
        self.outputs = SimOutputs(self.node, topics, self.recording, parameters, plant)
        self.simulation = Simulation(plant, self.outputs, self.logger, parameters)
        self.gate = command_gate([parameters.tf_prefix + name for name in JOINT_NAMES],
                                 parameters, time.monotonic)
        self.steps = StepQueue(self.node, self._loop)
        self.inputs = SimInputs(self._loop, topics, self.recording, self.simulation, self.gate,
                                self.steps, parameters)
        stop.started()  # from here on there is a bag to close
        self.recording.begin(self.run_name, describe(
            'sim', self.run_name, plant.arm.name, arm_text(parameters.arm), parameters.by_name(),
            topics.names, fingerprint(), world_text(parameters.world)))
        self.outputs.introduce(self.run_name, urdf_text(
            plant.arm, parameters.tf_prefix, world=plant.world))
        self._turns = SimLoop(self.simulation, self.inputs, self.gate, parameters)
        create_services(self.node, self)
        self._every_second = EverySecond()
        self.publishers_conflict = False
        """Whether two nodes ever commanded the arm at once."""
        self.second_simulator = ''
        """Name of a node that publishes on the same topic of states; empty = none."""
        self.waiting_line = Throttle(WAITING_PERIOD)
        poll_graph(self.node, lambda: check_publishers(self))
        self._loop.start()

    def begin(self) -> None:
        """Send state 1."""
        use_realtime(self.parameters.realtime_priority, self.logger)
        where = self.recording.folder or 'nowhere'
        self.logger.info(f'run {self.run_name}, recorded in {where}')
        if not self.simulation.plant.arm.armature.any():
            self.logger.info(light_joints(self.simulation.plant))
        self._turns.begin()

    def turn(self) -> bool:
        """Take a period, or receive what comes; return whether there was anything to do."""
        busy = self._turns.turn()
        if self.simulation.finished:
            self.stop.ask('stop_after')
        if self._every_second.due():
            self.steps.expire(self.simulation)
            self.simulation.log_present()
            report(self)
        return busy

    def pause(self, paused: bool) -> str:
        """Stop or let go simulated time."""
        word = self.simulation.pause(paused)
        self.simulation.stopped = False
        if not self.simulation.paused:
            self.steps.refuse_all(self.simulation, 'the pause ended first')
            self.gate.resumed()
        return word

    def stop_simulation(self) -> None:
        """Put the arm back and let time stand still; periods under way are not taken."""
        self.pause(True)
        self.steps.refuse_all(self.simulation, 'the simulation was stopped')
        self.reset()
        self.simulation.stopped = True

    def reset(self) -> str:
        """Put the arm back to its initial state."""
        word = self.simulation.reset()
        self.gate.was_reset(self.simulation.plant.k)
        return word

    def resume_torque_mode(self) -> str:
        """Let commands act again after silence ended torque mode."""
        return self.simulation.plant.resume_torque_mode()

    def change(self, changes: dict[str, Any]) -> None:
        """Change live parameters, all or none; they act from the next period."""
        plant = self.simulation.plant
        before = plant.parameters.by_name()
        done: list[str] = []
        try:
            for name, value in changes.items():
                if value != before[name]:
                    done.append(name)
                    plant.change(name, value)
        except Exception:
            for name in done:
                plant.change(name, before[name])
            raise
        finally:
            self.simulation.send_events(plant)

    def end(self, reason: str) -> int:
        """Bring the arm to rest, close the bag, and return the exit code."""
        self.inputs.requests.close()
        if reason == self.stop.reason != 'stop_after':
            self.simulation.rest()
        self.steps.refuse_all(self.simulation, 'the node ends')
        report(self)
        self._loop.close()
        self.recording.end({
            'reason': reason, 'run': self.run_name,
            'hashes': {'joint_states': self.outputs.hash.hexdigest(),
                       'joint_command': self.inputs.hash.hexdigest()},
            'periods': self.outputs.hash.count, 'lockstep_fired': self.gate.fired,
            'repeatable': self.gate.repeatable and self.parameters.lockstep,
            'publishers_conflict': self.publishers_conflict,
            'counters': counters(self),
        })
        self.simulation.plant.close()
        return end_node(self.node, self.recording,
                        f'ends at {self.simulation.plant.stamp * 1e-9:.3f} s: {reason}')


def light_joints(plant: Plant) -> str:
    """Return what damping the joints of an arm without rotors carry, and which arm has rotors."""
    name, rate = plant.parameters.arm, plant.parameters.control_rate
    damping = ', '.join(f'{float(f"{each:.2g}"):g}'
                        for each in plant.mechanics.largest_damping(rate))
    heavier = 'ur5_real' if name == 'ur5' else name + ASSUMED
    known = heavier == 'ur5_real' or heavier in arms_with_assumed_armature()
    return (f'arm {name} has no rotor inertia: at {rate} Hz its joints '
            f'carry a damping of at most about {damping} N m s/rad'
            + (f'; arm:={heavier} has the rotor inertia of the robot' if known else ''))
