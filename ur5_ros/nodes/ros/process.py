"""From the command line to a running node and back: environment, start, end, exit code."""

import ctypes
import gc
import mmap
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
import rclpy.logging
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from ur5_ros.config.parameter_files import files_of, sections
from ur5_ros.errors import InputError
from ur5_ros.model.kernels.compile_notice import on_compile
from ur5_ros.nodes.ros.environment import BAD_INPUT, print_refusal
from ur5_ros.nodes.ros.recording import Recording
from ur5_ros.nodes.ros.shutdown import StopRequest
from ur5_ros.nodes.ros.wait_set_loop import spin_time
from ur5_ros.wording import agree, number_of

#: Exit codes besides BAD_INPUT: done; an error of the program; done, but the recording lost some.
SUCCESS, FAULT, WITH_LOSS = 0, 1, 3

#: Longest wait of the loop for the interpreter while another thread computes [s].
SWITCH_INTERVAL = 0.0002


def pin_to_core(core: str) -> None:
    """
    Keep this process, and every thread that it starts later, on one core.

    Without a core for each of two nodes in lockstep, sharing one saves the waking of another.
    Scheduled as a batch job, neither then interrupts the other when a message wakes it: the sender
    first ends its period (sched(7), SCHED_BATCH).
    """
    allowed = os.sched_getaffinity(0)
    if not (core.isascii() and core.isdigit() and int(core) in allowed):
        raise InputError(f'UR5_ROS_CORE is {core!r}; give one of: '
                         f'{", ".join(map(str, sorted(allowed)))}, or unset it')
    os.sched_setaffinity(0, {int(core)})
    if spin_time():  # it has the core for itself
        return
    if os.sched_getscheduler(0) == os.SCHED_OTHER:  # another policy is a choice of the user's
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def run_node(
    create: Callable[[list[Path], StopRequest], Any], stop: StopRequest,
    arguments: Sequence[str] | None = None,
) -> None:
    """
    Run a node as this process, and exit.

    ``create``: makes the node from its parameter files and the request to stop; the node has
    ``begin()``, ``turn()``, which is called until the request has a reason, and ``end(reason)``,
    which returns the exit code; ``arguments``: command line, program name first; ``sys.argv`` by
    default.
    """
    arguments = sys.argv if arguments is None else arguments
    try:
        code = _run(create, arguments, stop)
    except InputError as error:
        print_refusal(arguments, error)
        code = BAD_INPUT
    finally:
        rclpy.try_shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    # Nothing is left to be written; the destructors of the middleware have crashed at exit before.
    os._exit(code)


def fault(logger: Any, error: Exception) -> str:
    """Log an unexpected error in one line, its place as a debug line; return it."""
    reason = f'fault: {type(error).__name__}: {error}'
    logger.error(reason)
    logger.debug(''.join(traceback.format_exception(error)))
    return reason


def end_node(node: Node, recording: Recording, message: str) -> int:
    """Log the end of a node and what its bag lacks, destroy it, and return the exit code."""
    logger, lost, failure = node.get_logger(), recording.lost, recording.failure
    if lost or failure:
        logger.error(f'{number_of(lost, "message")} {agree(lost, "are")} in no bag: '
                     f'{failure or "too many at once"}')
    logger.info(message)
    node.destroy_node()  # the others would list it for seconds otherwise
    return WITH_LOSS if lost or failure else SUCCESS


@contextmanager
def compiling(logger: Any) -> Iterator[None]:
    """Log that kernels are compiled, and how long it took."""
    compiled: list[str] = []
    began = time.monotonic()

    def notice(name: str) -> None:
        if not compiled:
            logger.info('compiling for this processor, once, for up to half a minute; '
                        'ur5 warm-up --all does it in advance')
        compiled.append(name)

    on_compile(notice)
    yield
    if compiled:
        logger.info(f'{len(compiled)} kernel{"s" if len(compiled) > 1 else ""} compiled in '
                    f'{time.monotonic() - began:.1f} s')


def freeze_garbage() -> None:
    """Keep collector and bag writer from holding up the loop, which makes no cycles."""
    gc.freeze()
    gc.disable()
    sys.setswitchinterval(SWITCH_INTERVAL)


def release_compiler() -> None:
    """
    Hand back the pages of LLVM's code, some 80 MiB, which are mapped once kernels are loaded.

    The next kernel that is loaded has the pages that it needs mapped again.
    """
    libc = ctypes.CDLL(None)
    for line in Path('/proc/self/maps').read_text().splitlines():
        if ' r-xp ' in line and line.endswith('/libllvmlite.so'):  # what is never written to
            begin, end = (int(address, 16) for address in line.split()[0].split('-'))
            libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(end - begin), mmap.MADV_DONTNEED)


def _run(create: Callable[..., Any], arguments: Sequence[str], stop: StopRequest) -> int:
    core = os.environ.get('UR5_ROS_CORE', '')
    if core:
        pin_to_core(core)
    files = files_of(arguments)
    for file in files:
        sections(file)  # refused in our words, before rcl reads it
    try:
        surplus = remove_ros_args(list(arguments))[1:]
        if surplus:
            raise InputError(f'unknown argument {surplus[0]!r}; parameters are given as '
                             '--ros-args -p name:=value or --ros-args --params-file file.yaml')
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
        node = create(files, stop)
    except ExternalShutdownException:
        return SUCCESS
    except Exception as error:
        if type(error).__module__.startswith('rclpy'):
            raise InputError(_one_line(error)) from None
        raise
    return _turns(node, stop)


def _turns(node: Any, stop: StopRequest) -> int:
    stop.started()
    freeze_garbage()
    release_compiler()
    try:
        node.begin()
        while not stop.reason:
            node.turn()
    except InputError as error:
        print_refusal(sys.argv, error)
        return max(BAD_INPUT, node.end(str(error)))
    except Exception as error:
        return max(FAULT, node.end(fault(rclpy.logging.get_logger('ur5_ros'), error)))
    return node.end(stop.reason)


def _one_line(error: Exception) -> str:
    """Return rcl's message about a bad argument or file, without its source lines."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    text = lines[0] if lines else type(error).__name__
    return text.partition(', at ')[0]
