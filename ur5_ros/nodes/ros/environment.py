"""Environment variables, checked before the middleware reads them: it would end the process."""

import os
import re
import socket
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.parsers import expat

from ur5_ros.errors import InputError

#: Exit code of a node that was given bad input.
BAD_INPUT = 2

#: Highest domain whose ports fit (DDSI-RTPS 2.5, section 9.6.2.3: 7400 + 250 domain).
HIGHEST_DOMAIN = 232

#: Variables of the middleware and of ROS logging that are misread without an end, and what they
#: may be (rcl/src/rcl/discovery_options.c, rcutils/src/logging.c).
WORDS = {
    'ROS_AUTOMATIC_DISCOVERY_RANGE': ('SUBNET', 'LOCALHOST', 'OFF', 'SYSTEM_DEFAULT'),
    'RCUTILS_LOGGING_BUFFERED_STREAM': ('0', '1'),
    'RCUTILS_LOGGING_USE_STDOUT': ('0', '1'),
    'RCUTILS_COLORIZED_OUTPUT': ('0', '1'),
}

#: The second one is read by Fast DDS 3, the first by Fast DDS 2.
PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')


def require_environment(arguments: Sequence[str] | None = None) -> None:
    """
    End this process in one line if :func:`check_environment` refuses its environment.

    ``arguments``: command line, program name first; ``sys.argv`` by default.
    """
    try:
        check_environment()
    except InputError as error:
        print_refusal(sys.argv if arguments is None else arguments, error)
        sys.exit(BAD_INPUT)


def print_refusal(arguments: Sequence[str], error: InputError) -> None:
    """Print a refusal on the error output."""
    program = os.path.basename(arguments[0]).removesuffix('.py') if arguments else 'node'
    print(f'{program}: {error}', file=sys.stderr)


def check_environment(environment: Mapping[str, str] | None = None) -> None:
    """
    Refuse an environment in which a node would not do what the user expects.

    To be called before rclpy is imported: its library ends the process by itself where
    ``RMW_IMPLEMENTATION`` names something else than it finds.

    ``environment``: variables to judge; the process's own by default.
    """
    env = os.environ if environment is None else environment
    domain = env.get('ROS_DOMAIN_ID', '')
    if domain and not (domain.isascii() and domain.isdigit() and int(domain) <= HIGHEST_DOMAIN):
        raise InputError(f'ROS_DOMAIN_ID is {domain!r}; give a whole number from 0 to '
                         f'{HIGHEST_DOMAIN}, or unset it')
    secured = env.get('ROS_SECURITY_ENABLE', '').lower() == 'true'
    if secured and env.get('ROS_SECURITY_STRATEGY', 'Permissive') != 'Enforce':
        raise InputError('ROS_SECURITY_ENABLE is true, but ROS_SECURITY_STRATEGY is not Enforce: '
                         'without its keys the node would run unsecured; set '
                         'ROS_SECURITY_STRATEGY=Enforce, or ROS_SECURITY_ENABLE=false')
    for name, words in WORDS.items():
        if env.get(name) and env[name] not in words:
            raise InputError(f'{name} is {env[name]!r}; give one of: {", ".join(words)}, '
                             'or unset it')
    for name in PROFILES:
        if env.get(name):
            _check_profile(name, env[name])
    for peer in filter(None, env.get('ROS_STATIC_PEERS', '').split(';')):
        try:
            socket.getaddrinfo(peer, None)
        except (OSError, UnicodeError):
            raise InputError(f'ROS_STATIC_PEERS names {peer!r}, a host that cannot be found; '
                             'correct it, or unset it') from None
    if env.get('RMW_IMPLEMENTATION'):
        _check_middleware(env['RMW_IMPLEMENTATION'])


def _check_profile(name: str, path: str) -> None:
    """Refuse a profile that is none: the middleware would open every interface without it."""
    reason = ''
    try:
        expat.ParserCreate().Parse(Path(path).read_bytes(), True)
    except OSError as error:
        reason = error.strerror or str(error)
    except (expat.ExpatError, ValueError) as error:
        reason = f'not XML: {error}'
    if reason:
        raise InputError(f'{name} is {path!r}: {reason}; without the profile every interface of '
                         'this machine would be open; correct it, or unset it')


def _check_middleware(name: str) -> None:
    """Load the middleware in a child process, whose exit code reports whether it is there."""
    readable, writable = os.pipe()
    child = os.fork()
    if child == 0:
        _load_middleware(writable)
    os.close(writable)
    with open(readable, 'rb') as pipe:
        output = pipe.read().decode(errors='replace')
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code != 0:
        found = re.search(r"instead found '(\w+)'", output)
        there = f' (there is {found[1]})' if found else ''
        raise InputError(f'RMW_IMPLEMENTATION is {name!r}, a middleware that is not installed'
                         f'{there}; install it, or unset RMW_IMPLEMENTATION')


def _load_middleware(report: int) -> None:
    code = 1
    try:
        os.dup2(report, 1)
        os.dup2(report, 2)
        from rclpy.impl.implementation_singleton import rclpy_implementation
        code = 0 if rclpy_implementation else 1
    finally:
        os._exit(code)
