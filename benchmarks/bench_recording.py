"""What recording costs the hot loop, per message, against publishing the same bytes."""

import os
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
import sink
from ping_pong import QOS
from sensor_msgs.msg import JointState
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.launcher.node_processes import private_environment
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.signals import JOINT_NAMES

MESSAGES = 3000
REPEATS = 9
#: Time between messages, as in a fast lockstep loop [s].
PAUSE = 100e-6


def paced(function, data: bytes, messages: int) -> tuple[float, float]:
    """Return the processor seconds of a call in this thread, and of the process per message."""
    own, whole = 0, time.process_time_ns()
    waiting = 0
    for _ in range(messages):
        begin = time.thread_time_ns()
        function(data)
        middle = time.thread_time_ns()
        own += middle - begin
        time.sleep(PAUSE)
        waiting += time.thread_time_ns() - middle
    clock = seconds_of_clock()
    whole = time.process_time_ns() - whole - waiting
    return own * 1e-9 / messages - clock, whole * 1e-9 / messages - clock


def seconds_of_clock() -> float:
    """Return what reading the clock twice adds [s]."""
    times = [(time.thread_time_ns(), time.thread_time_ns()) for _ in range(1000)]
    return float(np.median([b - a for a, b in times])) * 1e-9


def recording(folder: Path, data: bytes, messages: int) -> tuple[float, float]:
    """Return the cost of recording a message: in the loop, and with the writer's thread."""
    bag = Recording(str(folder), 'sim', 0.0, 0)
    topic = bag.topic('/joint_states', 'sensor_msgs/msg/JointState')
    bag.begin('benchmark', {})
    write = bag.write
    costs = paced(lambda message: write(topic, message), data, messages)
    bag.end({})
    assert bag.lost == 0
    return costs


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    messages, repeats = (300, 1) if options.quick else (MESSAGES, options.repeats)
    os.environ.update(private_environment())
    data = FixedJointState(JOINT_NAMES).encode(1, *np.random.default_rng(1).normal(size=(3, 6)))
    rclpy.init()
    publisher = rclpy.create_node('benchmark').create_publisher(JointState, '/benchmark', QOS)
    send = publisher.publish
    child = sink.start('/benchmark')
    costs: dict[str, list[tuple[float, float]]] = {'record': [], 'publish': []}
    try:
        sink.wait_for(publisher)
        with tempfile.TemporaryDirectory(prefix='ur5-bench-') as name:
            found = iter(range(1000))
            costs = interleave({
                'record': lambda: recording(Path(name) / f'bag{next(found)}', data, messages),
                'publish': lambda: paced(send, data, messages),
            }, repeats)
    finally:
        child.kill()
        child.wait()
    figures = {'in the loop': [each[0] for each in costs['record']],
               'thread included': [each[1] for each in costs['record']],
               'publish': [each[0] for each in costs['publish']]}
    median = {name: float(np.median(values)) for name, values in figures.items()}
    reference = 'publish(bytes) to one subscription'
    publish('recording', 'Recording in the hot loop, a message of 316 bytes, processor time', [
        Row('recording, in the loop', reference, ratio(figures, 'in the loop', 'publish'), 1.5,
            False, f'{median["in the loop"] * 1e6:.1f} us against '
            f'{median["publish"] * 1e6:.1f} us'),
        Row("recording, the writer's thread included", reference,
            ratio(figures, 'thread included', 'publish'), 1.5, False,
            f'{median["thread included"] * 1e6:.1f} us'),
    ], {'seconds': figures}, keep=not options.quick)
    os._exit(0)


if __name__ == '__main__':
    main()
