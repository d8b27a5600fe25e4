"""Where a lockstep period goes: each part of both nodes by itself, and what is left."""

import os
import tempfile
import time
from collections import defaultdict

import numpy as np
import rclpy
import sink
from ping_pong import QOS, measure
from sensor_msgs.msg import JointState
from side_by_side import Row, arguments, publish
from two_nodes_recorded import ONE_CORE, per_second, run

from ur5_ros.bag.payload_hash import PayloadHash
from ur5_ros.cdr.fixed_messages import FixedJointState, FixedTrajectoryPoint, encode_stamp
from ur5_ros.config.topics import HOT
from ur5_ros.control.computed_torque import computed_torque
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.gains import gains_from
from ur5_ros.launcher.node_processes import last_core, private_environment
from ur5_ros.loop.run_config import RunConfig, run_config
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.nodes.control.topics import PARTS
from ur5_ros.nodes.ros.messages import EffortReader, StateReader
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.topics import ros_profile
from ur5_ros.nodes.ros.wait_set_loop import WaitSetLoop
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.command_gate import CommandGate
from ur5_ros.sim.lockstep_gate import command_gate
from ur5_ros.sim.plant import plant_from_parameters

PERIODS = 4000
REPEATS = 3


def decide(data: bytes, reader: EffortReader, gate: CommandGate) -> np.ndarray:
    """Return the torques of a command after all that the simulator checks."""
    stamp, _, effort = reader.read(data)
    assert gate.offer('', stamp, effort) is None
    return gate.next().command


class Laps:
    """Processor time of this thread by name."""

    def __init__(self) -> None:
        self.total: dict[str, int] = defaultdict(int)
        times = [(time.thread_time_ns(), time.thread_time_ns()) for _ in range(1000)]
        self._clock = int(np.median([b - a for a, b in times]))

    def __call__(self, name: str, function, *given):
        """Return what ``function`` returns, and take note of what it cost."""
        begin = time.thread_time_ns()
        result = function(*given)
        self.total[name] += time.thread_time_ns() - begin - self._clock
        return result


def parts_of_a_period(plan: RunConfig, periods: int, publish_bytes, take) -> dict[str, float]:
    """Return the processor time of each part of a period [s], both nodes together."""
    lap = Laps()
    plant = plant_from_parameters(plan.sim)
    controller = controller_from_parameters(plan.control, 1000)
    gate = command_gate(JOINT_NAMES, plan.sim, time.monotonic)
    states = FixedJointState(JOINT_NAMES)
    commands = FixedJointState(JOINT_NAMES, fields=('effort',))
    points = FixedTrajectoryPoint(JOINT_NAMES)
    parts = FixedJointState([f'{part}/{name}' for part in PARTS for name in JOINT_NAMES],
                            fields=('effort',))
    digests = PayloadHash(states), PayloadHash(commands)
    gains = gains_from(plan.control.kp, plan.control.kd)
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        bag = Recording(f'{folder}/bag', 'sim', 0.0, 0)
        topic = bag.topic('/joint_states', 'sensor_msgs/msg/JointState')
        bag.begin('benchmark', {})
        sent = states.encode(*plant.state)
        controller.update(plant.state)
        reader, read_state = EffortReader(JOINT_NAMES), StateReader(JOINT_NAMES).read
        for _ in range(periods):
            lap('publish', publish_bytes, sent)
            lap('take', take)
            seen = lap('decode', read_state, sent)
            answer = lap('law, its model and its checks', controller.update, seen)
            when = lap('encode', encode_stamp, seen.stamp)
            torque, expected = answer.parts.tobytes(), answer.reference
            command = lap('encode', commands.join, when, b'', b'', torque[:48])
            lap('publish', publish_bytes, command)
            point = lap('encode', points.join, when, *(x.tobytes() for x in expected), torque[:48])
            split = lap('encode', parts.join, when, b'', b'', torque)
            lap('take', take)
            tau = lap('check the command', decide, command, reader, gate)
            state = lap('step', plant.step, tau)
            when = lap('encode', encode_stamp, state.stamp)
            sent = lap('encode', states.join, when, *(x.tobytes() for x in state[1:]))
            lap('check the command', gate.published, plant.k)
            for message in (sent, when, command, sent, command, point, split):
                lap('record', bag.write, topic, message)
            for digest, message in zip((*digests, *digests), (sent, command) * 2, strict=True):
                lap('hash', digest.add, message)
            lap('of the law: the model', dynamics_terms, seen.q, seen.qd, controller.arm)
            lap('of the law: model and sums', computed_torque, seen, expected, controller.arm,
                gains)
        bag.end({})
    plant.close()
    return {name: total * 1e-9 / periods for name, total in lap.total.items()}


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    periods, repeats = (300, 1) if options.quick else (PERIODS, options.repeats)
    os.environ.update(private_environment())
    plan = run_config(duration=5.0)
    rclpy.init()
    node = rclpy.create_node('benchmark')
    publisher = node.create_publisher(JointState, '/benchmark', QOS)
    loop = WaitSetLoop(node)
    loop.subscribe(JointState, '/benchmark', ros_profile(HOT))
    child = sink.start('/benchmark')
    found = []
    try:
        sink.wait_for(publisher)
        for _ in range(repeats):
            found.append(parts_of_a_period(plan, periods, publisher.publish, loop.take))
    finally:
        child.kill()
        child.wait()
    parts = {name: float(np.median([each[name] for each in found])) for name in found[0]}
    seconds, trips = (1.0, 300) if options.quick else (8.0, 4000)
    period = 1.0 / per_second(run(run_config(duration=seconds), ONE_CORE).states)
    trip = 1.0 / measure('wait_set', trips, last_core())['per_second']
    work = sum(cost for name, cost in parts.items() if not name.startswith('of the law'))
    work -= parts['publish'] + parts['take']  # the ping-pong has them too
    parts = dict(sorted(parts.items(), key=lambda item: -item[1]))
    parts['ping-pong, kept wait set: waits, publishes, takes'] = trip
    parts['left: threads of the bag, the executor beside the loop, cold caches'] = (
        period - trip - work)
    parts['period measured'] = period
    for name, cost in parts.items():
        print(f'  {name:70} {cost * 1e6:8.1f} us')
    publish('profile', 'Where the time of a lockstep period goes', [
        Row('what the nodes do beside messaging', 'ping-pong, kept wait set, one core',
            work / trip, 1 / 0.75 - 1.0, False,
            f'{work * 1e6:.0f} us against {trip * 1e6:.0f} us: above it the bar of 0.75 is out '
            'of reach'),
    ], {'parts': parts}, keep=not options.quick)
    os._exit(0)


if __name__ == '__main__':
    main()
