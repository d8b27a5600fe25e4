"""
Bare rclpy ping-pong: one JointState each way between two processes, nothing done with it.

The reference of the loop's speed: what the middleware costs by itself.  Two ways of taking: the
stock SingleThreadedExecutor with message objects, and one wait set kept and re-armed with raw
bytes.  Publishers and subscriptions are reliable, keep last 1, as in the loop.

    python benchmarks/ping_pong.py --how executor --trips 5000
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from array import array
from contextlib import suppress
from typing import NoReturn

import child
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from ur5_ros.launcher.node_processes import private_environment
from ur5_ros.nodes.ros.process import pin_to_core

QOS = QoSProfile(depth=1)
NAMES = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',
         'wrist_2_joint', 'wrist_3_joint']
WARM_UP = 200
#: A message of a ping-pong that has not come back after this wall time is lost [s].
TRIP_TIMEOUT = 0.2
#: Both sides have to find each other, and the other one has to end, within this wall time [s].
PEER_TIMEOUT = 20.0
#: Round trips that may be lost before the reference means nothing.
MAX_LOST = 100


def message() -> JointState:
    """Return a JointState as large as the loop's."""
    return JointState(name=NAMES, position=array('d', range(6)), velocity=array('d', range(6)),
                      effort=array('d', range(6)))


class Taker:
    """A wait set of one subscription, kept and re-armed."""

    def __init__(self, node, subscription):
        self.handle = subscription.handle
        self.guard = node.context.handle
        self.wait_set = _rclpy.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    def take(self, timeout: float = TRIP_TIMEOUT) -> bytes | None:
        """Return the next message's bytes, or None after the timeout [s]."""
        with self.handle:
            self.wait_set.clear_entities()
            self.wait_set.add_subscription(self.handle)
            self.wait_set.wait(int(timeout * 1e9))
            taken = self.handle.take_message(JointState, True)
        return taken[0] if taken else None


def leave(node: Node) -> NoReturn:
    """End this process without leaving shared memory of the middleware behind."""
    node.destroy_node()  # the last one takes the participant with it
    rclpy.try_shutdown()
    sys.stdout.flush()
    os._exit(0)


def pong(how: str) -> NoReturn:
    """Answer every ping until the parent sends SIGTERM."""
    rclpy.init()
    node = rclpy.create_node('pong')
    publisher = node.create_publisher(JointState, 'pong', QOS)
    if how == 'executor':
        node.create_subscription(
            JointState, 'ping',
            lambda state: publisher.publish(JointState(
                header=state.header, name=state.name, position=state.position,
                velocity=state.velocity, effort=state.effort)), QOS)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        print('ready', flush=True)
        with suppress(ExternalShutdownException, _rclpy.RCLError):
            executor.spin()
        leave(node)
    subscription = node.create_subscription(JointState, 'ping', lambda _: None, QOS, raw=True)
    taker = Taker(node, subscription)
    print('ready', flush=True)
    while rclpy.ok():
        data = taker.take(0.2)
        if data is not None:
            publisher.publish(data)
    leave(node)


def ping(node: Node, how: str, trips: int) -> tuple[list[float], int]:
    """Return the time of each round trip [s], and how many were lost."""
    publisher = node.create_publisher(JointState, 'ping', QOS)
    times: list[float] = []
    if how == 'executor':
        answers: list[JointState] = []
        node.create_subscription(JointState, 'pong', answers.append, QOS)
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def trip() -> bool:
            answers.clear()
            publisher.publish(message())
            limit = time.perf_counter() + TRIP_TIMEOUT
            while not answers and time.perf_counter() < limit:
                executor.spin_once(timeout_sec=TRIP_TIMEOUT)
            return bool(answers)
    else:
        subscription = node.create_subscription(JointState, 'pong', lambda _: None, QOS, raw=True)
        taker = Taker(node, subscription)
        data = bytes(serialize_message(message()))

        def trip() -> bool:
            publisher.publish(data)
            return taker.take() is not None

    limit = time.perf_counter() + PEER_TIMEOUT
    while not (publisher.get_subscription_count() and node.count_publishers('pong')):
        if time.perf_counter() > limit:
            raise SystemExit(f'ping and pong did not find each other in {PEER_TIMEOUT:g} s; '
                             'run it again')
        time.sleep(0.01)
    lost = 0
    for index in range(WARM_UP + trips):
        start = time.perf_counter()
        if not trip():
            lost += 1
            if lost > MAX_LOST:
                raise SystemExit(f'{lost} of {index + 1} round trips were lost; the machine is '
                                 'too busy for this reference: run it again when it is quiet')
        elif index >= WARM_UP:
            times.append(time.perf_counter() - start)
    return times, lost


def measure(how: str, trips: int, core: int | None = None,
            transports: str = 'loopback', priority: int = 0) -> dict[str, float]:
    """
    Return what a ping-pong in two fresh processes takes.

    Parameters
    ----------
    how : {'executor', 'wait_set'}
        How messages are taken.
    trips : int
        Round trips after the warm-up.
    core : int, optional
        Keep both processes on this core, scheduled as the nodes are there.
    transports : {'loopback', 'default'}
        The profile that the nodes use, or what Fast DDS does by itself.
    priority : int, optional
        Schedule both processes by SCHED_FIFO with this priority.

    Returns
    -------
    dict
        Of the trips that were answered: round trips a second, p50 and p99 of one [s];
        ``answered`` and ``lost`` count them.

    """
    command = [sys.executable, __file__, '--how', how, '--trips', str(trips),
               '--priority', str(priority)]
    if core is not None:
        command += ['--core', str(core)]
    environment = private_environment()
    if transports == 'default':
        del environment['FASTRTPS_DEFAULT_PROFILES_FILE']
    done = child.call(command, capture_output=True, text=True, timeout=300, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    """Run one side, or both."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--how', choices=('executor', 'wait_set'), default='executor')
    parser.add_argument('--trips', type=int, default=5000)
    parser.add_argument('--core', type=int)
    parser.add_argument('--priority', type=int, default=0)
    parser.add_argument('--pong', action='store_true', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.core is not None:
        pin_to_core(str(options.core))
    if options.priority:  # before the middleware starts its threads; the child inherits it
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(options.priority))
    if options.pong:
        pong(options.how)
    os.environ.setdefault('ROS_DOMAIN_ID', str(100 + os.getpid() % 100))
    other = child.start([sys.executable, __file__, '--pong', '--how', options.how],
                        stdout=subprocess.PIPE)
    rclpy.init()
    node = rclpy.create_node('ping')
    try:
        other.stdout.readline()
        times, lost = ping(node, options.how, options.trips)
    finally:
        other.terminate()
        try:
            other.wait(PEER_TIMEOUT)
        except subprocess.TimeoutExpired:
            other.kill()
            other.wait()
    times.sort()
    print(json.dumps({'per_second': len(times) / sum(times), 'p50': statistics.median(times),
                      'p99': times[int(0.99 * len(times))], 'answered': len(times),
                      'lost': lost}))
    leave(node)


if __name__ == '__main__':
    main()
