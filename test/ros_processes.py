"""
Nodes as processes for tests: a domain of their own, ended by pid whatever happens, nothing left.

Use the fixture ``ros`` (test/nodes/conftest.py): it starts nodes, gives an observer in the same
domain, and waits for conditions instead of sleeping.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import rclpy
from node_starter import Forked, Starter
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ur5_ros.launcher.node_processes import claim_domain, parameter_text, private_environment
from ur5_ros.nodes.ros.wait_set_loop import ReservedGroup

SHARED_MEMORY = Path('/dev/shm')
MODULES = {'sim': 'ur5_ros.nodes.sim_node', 'control': 'ur5_ros.nodes.control_node',
           'closed_loop': 'ur5_ros.nodes.closed_loop'}

#: Wall time between two looks of an observer at what has come [s].
TAKE_PERIOD = 0.002
#: Wall time after which a condition that has not come true fails a test [s].
TIMEOUT = 60.0


def wait_until(condition: Callable[[], Any], what: str, seconds: float = TIMEOUT) -> Any:
    """Return the first true value of ``condition()``; fail with ``what`` if none comes."""
    end = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f'waited {seconds:g} s in vain for: {what}')
        time.sleep(0.01)


def send_until(send: Callable[[], None], condition: Callable[[], Any], what: str) -> None:
    """
    Send until a condition comes true: best effort may lose a message of many fragments.

    Each time it waits three seconds, in which diagnostics come three times.

    """
    for _ in range(int(TIMEOUT / 3.0)):
        send()
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            if condition():
                return
            time.sleep(0.01)
    raise AssertionError(f'sent in vain for: {what}')


def processes_with(variable: str) -> list[str]:
    """Return the ids of the processes that were started with an environment variable."""
    found = []
    for path in Path('/proc').glob('[0-9]*/environ'):
        with suppress(OSError):  # it may end meanwhile
            if variable.encode() in path.read_bytes().split(b'\0'):
                found.append(path.parent.name)
    return found


@cache
def starter() -> Starter:
    """Return what starts the nodes of all tests of this process."""
    return Starter()


def watched() -> bool:
    """Return whether the lines that run are counted, which no fork would do."""
    coverage = sys.modules.get('coverage')
    return coverage is not None and coverage.Coverage.current() is not None


class Process:
    """A node as a process of its own."""

    def __init__(self, popen: subprocess.Popen | Forked, log: Path) -> None:
        self.popen, self.log = popen, log
        self.pid = popen.pid

    @property
    def text(self) -> str:
        """What it printed so far."""
        return self.log.read_text(errors='replace')

    def lacks(self, package: str) -> None:
        """Check that one line names a package that is not installed, and what to install."""
        assert self.text.count(f'{package} is not installed') == 1, self.text
        assert f'ros-jazzy-{package.replace("_", "-")}' in self.text

    def wait_for_line(self, text: str, seconds: float = TIMEOUT) -> None:
        """Wait until it has printed ``text``."""
        wait_until(lambda: text in self.text or self.popen.poll() is not None and 'ended',
                   f'{text!r} from the node, which says: {self.text}', seconds)
        assert text in self.text, f'ended without saying {text!r}: {self.text}'

    def ends(self, seconds: float = TIMEOUT) -> int:
        """Wait for its end and return the exit code."""
        try:
            return self.popen.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f'did not end within {seconds:g} s: {self.text}') from None

    def stop(self, number: int = signal.SIGINT) -> int:
        """Send a signal and return the exit code."""
        self.popen.send_signal(number)
        return self.ends()

    def kill(self) -> None:
        """End it at once."""
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGCONT)
            self.popen.kill()
        self.popen.wait()


class Ros:
    """Processes and observers in one ROS domain."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # held until the end: tests that run at the same time get other domains
        self.domain, self._claim = claim_domain()
        self.environment = private_environment() | {
            'ROS_DOMAIN_ID': str(self.domain), 'ROS_LOG_DIR': str(folder / 'ros_log')}
        self.environment.pop('UR5_ROS_CORE', None)
        self.processes: list[Process] = []
        self._observers: list[Observer] = []

    def start(
        self, node: str, arguments: list[str] | None = None,
        environment: Mapping[str, str] | None = None, namespace: str = '', fresh: bool = False,
        **parameters: Any,
    ) -> Process:
        """
        Start ``sim`` or ``control``; parameters with a dot in their name go by ``__``.

        Parameters
        ----------
        node : str
            ``'sim'`` or ``'control'``.
        arguments : list of str, optional
            More of the command line.
        environment : mapping, optional
            Variables set besides those of the domain; the node then imports everything itself.
        namespace : str
            ROS namespace.
        fresh : bool
            Whether the node imports everything itself, as it does for users.
        **parameters
            ROS parameters.

        """
        command = ['--ros-args']
        for name, value in parameters.items():
            command += ['-p', f'{name.replace("__", ".")}:={parameter_text(value)}']
        if namespace:
            command += ['-r', f'__ns:={namespace}']
        command += arguments or []
        if fresh or environment or watched():
            return self.run([sys.executable, '-m', MODULES[node], *command], environment)
        return self._add(starter().start(MODULES[node], command, self.folder, self._new_log(),
                                         self.environment))

    def run(self, command: list[str], environment: Mapping[str, str] | None = None) -> Process:
        """Start any program in this domain."""
        with open(self._new_log(), 'wb') as out:
            return self._add(subprocess.Popen(
                command, cwd=self.folder, env=self.environment | dict(environment or {}),
                stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT))

    def _new_log(self) -> Path:
        """Return the file for the output of the next process."""
        log = self.folder / f'process_{len(self.processes)}.log'
        log.touch()
        return log

    def _add(self, popen: subprocess.Popen | Forked) -> Process:
        self.processes.append(Process(
            popen, self.folder / f'process_{len(self.processes)}.log'))
        return self.processes[-1]

    def observer(self, name: str = 'observer') -> 'Observer':
        """Return a node of this process in the domain."""
        observer = Observer(name, self.domain)
        self._observers.append(observer)
        return observer

    def bag(self, node: str) -> Path:
        """Return the only bag of a node below the working folder of the processes."""
        found = sorted((self.folder / 'bags').glob(f'*/{node}'))
        assert len(found) == 1, f'{len(found)} bags of {node}: {found}'
        return found[0]

    def close(self) -> None:
        """End everything."""
        for observer in self._observers:
            observer.close()
        for process in self.processes:
            process.kill()
        self._claim.close()


class Observer:
    """
    A node in this process that collects messages; its executor spins in a thread.

    A second thread takes messages, all that have come at a time: an executor's wait for each of
    some thousands a second would take the processor from the nodes that are observed.
    """

    def __init__(self, name: str, domain: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = Node(name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._ending = False
        self._takers: list[Callable[[], None]] = []
        self._group = ReservedGroup()
        self._threads = [threading.Thread(target=each, daemon=True)
                         for each in (self._spin, self._listen)]
        for thread in self._threads:
            thread.start()

    def subscribe(self, message_type: type, topic: str, kept: bool = False,
             react: Callable[[Any], None] | None = None, publishers: int = 1) -> list[Any]:
        """Return a list that fills with the messages of a topic once it is published."""
        received: list[Any] = []

        def take(message: Any) -> None:
            received.append(message)
            if react is not None:
                react(message)

        durability = DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=1000, durability=durability,
                         reliability=ReliabilityPolicy.RELIABLE
                         if topic != '/clock' else ReliabilityPolicy.BEST_EFFORT)
        subscription = self.node.create_subscription(message_type, topic, take, qos,
                                                     callback_group=self._group)
        handle = subscription.handle

        def take_all() -> None:
            while (taken := handle.take_message(message_type, False)) is not None:
                take(taken[0])

        self._takers.append(take_all)
        wait_until(lambda: subscription.handle.get_publisher_count() >= publishers,
                   f'a publisher of {topic}')
        return received

    def publisher(self, message_type: type, topic: str, subscribers: int = 1,
                  kept: bool = False) -> Any:
        """Return a publisher that has its subscribers already."""
        durability = DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE
        publisher = self.node.create_publisher(
            message_type, topic, QoSProfile(depth=10, durability=durability))
        wait_until(lambda: publisher.get_subscription_count() >= subscribers,
                   f'a subscriber of {topic}')
        # the subscriber may know less of us than we of it, as a server below
        time.sleep(0.3)
        return publisher

    def in_its_thread(self, call: Callable[[], Any]) -> Any:
        """
        Return what a call gives that is made by the thread that spins.

        rclpy's action client notes a request after it is sent: an answer that another thread takes
        before that is dropped, and the request waits for ever.
        """
        task = self._executor.create_task(call)
        wait_until(task.done, 'the call in the thread that spins')
        return task.result()

    def call(self, service_type: type, name: str, request: Any = None,
             seconds: float = TIMEOUT) -> Any:
        """Call a service and return its response."""
        future = self.call_async(service_type, name, request)
        wait_until(future.done, f'an answer from {name}', seconds)
        return future.result()

    def call_async(self, service_type: type, name: str, request: Any = None) -> Any:
        """Call a service and return the future of its response."""
        client = self._clients.get(name)
        if client is None:
            # rclpy's own depth is ten: a flood of calls, or its answers, would lose the oldest
            client = self._clients[name] = self.node.create_client(
                service_type, name, qos_profile=QoSProfile(depth=100))
            wait_until(client.service_is_ready, f'service {name}')
            # the server may know less of us than we of it, and nobody can ask it: an answer that
            # finds no reader is dropped
            time.sleep(0.3)
        return client.call_async(request if request is not None else service_type.Request())

    def set_parameters(self, node: str, **values: Any) -> Any:
        """Set parameters of a node at once, a dot as ``__``; return the result."""
        request = SetParametersAtomically.Request(parameters=[
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
            for name, value in values.items()])
        return self.call(SetParametersAtomically, f'/{node}/set_parameters_atomically',
                         request).result

    def close(self) -> None:
        """Leave the domain."""
        self._ending = True
        self._executor.wake()
        for thread in self._threads:
            thread.join(5.0)
        self.node.destroy_node()
        self._context.try_shutdown()

    def _spin(self) -> None:
        while not self._ending:
            self._executor.spin_once(timeout_sec=0.2)

    def _listen(self) -> None:
        while not self._ending:
            for take_all in self._takers[:]:
                take_all()
            time.sleep(TAKE_PERIOD)


@contextmanager
def ros_domain(folder: Path) -> Iterator[Ros]:
    """Give a domain of its own and leave nothing behind."""
    began = time.time() - 1.0
    ros = Ros(folder)
    profile = {'FASTRTPS_DEFAULT_PROFILES_FILE':
               ros.environment['FASTRTPS_DEFAULT_PROFILES_FILE']}
    os.environ.update(profile)
    try:
        yield ros
    finally:
        ros.close()
        clean_shared_memory(began)


def clean_shared_memory(since: float) -> None:
    """Remove what Fast DDS made since then and no living process has mapped."""
    files = [file for pattern in ('fastrtps_*', 'sem.fastrtps_*')
             for file in SHARED_MEMORY.glob(pattern)]
    mapped = _mapped_files()
    for file in files:
        try:
            if file.stat().st_ctime >= since and _segment(file.name) not in mapped:
                file.unlink()
        except OSError:
            continue  # somebody else was quicker, or owns it


def _mapped_files() -> set[str]:
    mapped = set()
    for maps in Path('/proc').glob('[0-9]*/maps'):
        try:
            lines = maps.read_text().splitlines()
        except OSError:
            continue
        mapped.update(_segment(line.split(maxsplit=5)[5].rpartition('/')[2])
                      for line in lines if '/dev/shm/' in line)
    return mapped


def _segment(name: str) -> str:
    """
    Return the segment that a file belongs to.

    Its lock (``_el``) and its mutex are mapped by nobody, and yet a living process that loses
    them is deaf from then on: others take its segment for a dead one's.
    """
    return name.removeprefix('sem.').removesuffix('_mutex').removesuffix('_el')
