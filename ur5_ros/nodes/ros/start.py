"""What a node does before its imports, which are most of its start."""

import gc
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from ur5_ros.nodes.ros.environment import require_environment
from ur5_ros.nodes.ros.shutdown import StopRequest


def executable(program: str, purpose: str, parameters: Sequence[str],
               node: str) -> Callable[..., None]:
    """
    Return the ``main`` of an executable: it prints its help, or is the node.

    ``parameters``: names of the declarations in ``config.parameters``; ``node``: ``module:class``
    below ``ur5_ros.nodes``, imported after the signals are listened to.
    """
    def main(arguments: Sequence[str] | None = None) -> None:
        """Run it; ``arguments``: command line, program name first; ``sys.argv`` by default."""
        if asks_for_help(sys.argv if arguments is None else arguments):
            from ur5_ros.config import parameters as declared
            from ur5_ros.nodes.ros.usage import usage
            shown = {each.name: each for name in parameters for each in getattr(declared, name)}
            print_help(usage(program, purpose, shown.values()))
            return
        stop = begin_start()
        require_environment(arguments)
        from ur5_ros.nodes.ros.process import run_node
        module, name = node.split(':')
        run_node(getattr(import_module(f'ur5_ros.nodes.{module}'), name), stop, arguments)

    return main


def print_help(text: str) -> None:
    """Print a text, whose reader may stop before its end, as ``head`` does."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def begin_start() -> StopRequest:
    """
    Listen to signals, put the garbage collector off and keep BLAS to one thread.

    The imports take longer than an impatient user waits, and their objects stay: looking through
    them for garbage takes a sixth of the start and finds none.  Matrices of six rows gain nothing
    from threads, which wait for work by spinning; a user's own choice counts.

    """
    stop = StopRequest()
    stop.listen()
    gc.disable()
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    return stop


def asks_for_help(arguments: Sequence[str]) -> bool:
    """Return whether a command line asks for help, outside of what is ROS's."""
    own = list(arguments)[1:]
    if '--ros-args' in own:
        own = own[:own.index('--ros-args')]
    return bool({'-h', '--help'}.intersection(own))
