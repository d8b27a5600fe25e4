"""The two nodes as child processes of a command: private network, one core, an end for each."""

import os
import random
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from ur5_ros.config import config_folder
from ur5_ros.errors import InputError
from ur5_ros.launcher.signals import end_with_parent, interrupted_by_sigterm

#: Wall-clock time that a node gets to close its bag after being asked to end [s].
END_TIMEOUT = 10.0

#: Below this load average the machine counts as quiet.
QUIET_LOAD = 1.0

#: How long a node with a core for itself looks for a message before it waits [s].
SPIN_TIME = 0.0003


class NodeProcesses:
    """Starts nodes and ends every one of them when the ``with`` block ends, however it ends."""

    def __init__(self, logs: Path) -> None:
        self.logs = logs
        self._domain: socket.socket | None = None
        if 'ROS_DOMAIN_ID' in os.environ:
            self.environment = private_environment()
        else:
            domain, self._domain = claim_domain()
            self.environment = private_environment() | {'ROS_DOMAIN_ID': str(domain)}
        self._children: dict[str, subprocess.Popen] = {}
        self._interrupted = interrupted_by_sigterm()

    def __enter__(self) -> 'NodeProcesses':
        self._interrupted.__enter__()
        return self

    def __exit__(self, kind: type | None, value: BaseException | None,
                 traceback: TracebackType | None) -> None:
        for name in self._children:
            self.end(name)
        self._interrupted.__exit__(None, None, None)
        if self._domain is not None:
            self._domain.close()

    def start(self, name: str, module: str, parameters: Mapping[str, Any],
              namespace: str = '', environment: Mapping[str, str] | None = None) -> None:
        """
        Start ``python -m module``.

        ``namespace``: of its node; empty = that of the environment; ``environment``: variables
        of this process alone, where the user has not set them.
        """
        arguments = [sys.executable, '-m', module, '--ros-args']
        for key, value in parameters.items():
            arguments += ['-p', f'{key}:={parameter_text(value)}']
        if namespace:
            arguments += ['-r', f'__ns:={namespace}']
        with open(self.logs / f'{name}.log', 'wb') as log:
            child = subprocess.Popen(
                arguments, env={**(environment or {}), **self.environment},
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                start_new_session=True, preexec_fn=end_with_parent)
        self._children[name] = child

    def poll(self, name: str) -> int | None:
        """Return the exit code of a node, None while it runs."""
        return self._children[name].poll()

    def pid(self, name: str) -> int:
        """Return the process id of a node."""
        return self._children[name].pid

    def end(self, name: str) -> int:
        """Ask a node to end, insist if it does not, and return its exit code."""
        child = self._children[name]
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            if child.poll() is not None:
                break
            child.send_signal(number)
            try:
                child.wait(END_TIMEOUT)
            except subprocess.TimeoutExpired:
                continue
        return child.wait()

    def wait(self, name: str, seconds: float) -> int | None:
        """Return the exit code of a node that ends within ``seconds``, None otherwise."""
        try:
            return self._children[name].wait(seconds)
        except subprocess.TimeoutExpired:
            return None

    def last_log_line(self, name: str) -> str:
        """Return the last line that a node printed."""
        text = (self.logs / f'{name}.log').read_text(errors='replace').strip()
        return text.splitlines()[-1].strip() if text else 'no output'


def private_environment() -> dict[str, str]:
    """
    Return the environment of nodes that only see each other, on this machine alone.

    A domain chosen by the user (``ROS_DOMAIN_ID``) is kept.

    """
    environment = dict(os.environ)
    environment.setdefault('ROS_DOMAIN_ID', str(free_domain()))
    environment['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(config_folder() / 'fastdds_loopback.xml')
    for name in ('FASTDDS_DEFAULT_PROFILES_FILE', 'ROS_AUTOMATIC_DISCOVERY_RANGE',
                 'ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER'):
        environment.pop(name, None)
    environment.setdefault('PYTHONUNBUFFERED', '1')
    return environment


def free_domain() -> int:
    """Return a ROS domain id without a listener on this machine; see :func:`claim_domain`."""
    domain, claim = claim_domain()
    claim.close()
    return domain


def claim_domain() -> tuple[int, socket.socket]:
    """
    Return a ROS domain id without a listener on this machine, and the socket that reserves it.

    Two that start nodes at the same time get two domains, although no node listens yet: until
    the socket is closed no other caller gets the domain.

    The ports of a domain start at 7400 + 250 domain (DDSI-RTPS 2.5, section 9.6.2.3); domains
    up to 101 stay below the ports that Linux gives to clients.

    """
    domains = list(range(1, 102))
    random.SystemRandom().shuffle(domains)
    for domain in domains:
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            claim.bind(f'\0ur5_ros/domain/{domain}')  # no file: it goes with the process
        except OSError:
            claim.close()
            continue
        first = 7400 + 250 * domain
        if all(_is_free(first + offset) for offset in (0, 10, 11, 12, 13)):
            return domain, claim
        claim.close()
    raise InputError('all ROS domains from 1 to 101 are in use on this machine; '
                     'set ROS_DOMAIN_ID yourself')


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('127.0.0.1', port))
        except OSError:
            return False
    return True


def lockstep_cores(load: float | None = None) -> list[dict[str, str]]:
    """
    Return what the environment of each of two nodes in lockstep should hold.

    On a quiet machine each has a core for itself, whose caches stay warm, and looks for the
    other's message for a while before it waits: nothing has to be woken.  With one core for both
    there is nothing to look for.  Where others compute too, being bound to a core that they use
    costs half of the speed or more.

    ``load``: load average; that of the last minute by default.
    """
    load = os.getloadavg()[0] if load is None else load
    cores = sorted(os.sched_getaffinity(0))[-2:]
    if load >= QUIET_LOAD:
        return [{'UR5_ROS_CORE': ''}] * 2
    if len(cores) < 2:
        return [{'UR5_ROS_CORE': str(last_core())}] * 2
    spin = f'{1e6 * SPIN_TIME:.0f}'
    return [{'UR5_ROS_CORE': str(core), 'UR5_ROS_SPIN': spin} for core in cores]


def last_core() -> int:
    """Return the last core that this process may use."""
    return max(os.sched_getaffinity(0))


def parameter_text(value: Any) -> str:
    """Return a value as ``-p name:=value`` takes it."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, list):
        return '[' + ', '.join(parameter_text(item) for item in value) + ']'
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return repr(value)
