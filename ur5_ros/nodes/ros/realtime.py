"""Real-time scheduling of the loop: SCHED_FIFO and memory that is not paged out (sched(7))."""

import ctypes
import os
from pathlib import Path
from typing import Any

#: How Fast DDS names the threads that receive messages.
_RECEIVERS = ('dds.udp.', 'dds.shm.')
#: From sys/mman.h: lock what is mapped now, and what will be.
_MCL_CURRENT, _MCL_FUTURE = 1, 2


def use_realtime(priority: int, logger: Any) -> None:
    """
    Schedule the loop by SCHED_FIFO and lock the memory of its process.

    The loop is the calling thread and those of the middleware that hand it messages; all others,
    also later ones, are scheduled as before.  Without the rights the node runs on
    with ordinary scheduling, and one line of the log names them.

    ``priority``: 1 to 99, the highest; 0 changes nothing.
    """
    if not priority:
        return
    try:
        for thread in (0, *_receivers()):
            os.sched_setscheduler(thread, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK,
                                  os.sched_param(priority))
    except OSError as error:
        logger.warning(
            f'realtime_priority {priority}: {error.strerror}; the loop runs without it. To get '
            'it: the lines "@realtime - rtprio 99" and "@realtime - memlock unlimited" in '
            '/etc/security/limits.conf, your user in the group realtime, a new login')
        return
    if ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT | _MCL_FUTURE):
        logger.warning(f'realtime_priority {priority}: memory cannot be locked '
                       f'({os.strerror(ctypes.get_errno())}); raise the limit memlock')
    logger.info(f'the loop runs with real-time priority {priority}')


def _receivers() -> list[int]:
    """Return the threads of this process in which messages arrive."""
    return [int(task.name) for task in Path('/proc/self/task').iterdir()
            if (task / 'comm').read_text().startswith(_RECEIVERS)]
