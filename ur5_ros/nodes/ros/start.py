"""What a node does before its imports, which are most of its start."""

import gc
import os
from collections.abc import Sequence

from ur5_ros.nodes.ros.shutdown import StopRequest


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
