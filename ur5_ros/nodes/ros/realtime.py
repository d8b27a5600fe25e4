"""Real-time scheduling of the loop: SCHED_FIFO, memory that is not paged out, cores kept awake."""

import ctypes
import os
import threading
from pathlib import Path
from typing import Any

#: How Fast DDS names the threads that receive messages.
_RECEIVERS = ('dds.udp.', 'dds.shm.')
#: What a thread with it starts does not get it too.
_POLICY = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
#: From sys/mman.h: lock what is mapped now, and what will be, once it is used; without the last
#: one, stacks and arenas that are never used take twice the memory of a node.
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
#: Holds, while it is open, the longest time that a core may take to wake [us], an int32: kernel
#: documentation, "PM Quality Of Service Interface".
CORE_LATENCY = Path('/dev/cpu_dma_latency')


def use_realtime(priority: int, logger: Any) -> None:
    """
    Schedule the loop by SCHED_FIFO and lock the memory of its process.

    The loop is the calling thread and those of the middleware that hand it messages.  The other
    threads of Python, of which one writes the bag, get a priority of one less: where a thread that
    has the interpreter waits for a processor, the loop waits too.  All others, also later ones,
    are scheduled as before.  Until the process ends no core sleeps so deeply that waking takes
    time.  Without the rights the node runs on with ordinary scheduling, and one line of the log
    names them.

    ``priority``: 1 to 99, the highest; 0 changes nothing.
    """
    if not priority:
        return
    try:
        for number in (0, *_receivers()):
            os.sched_setscheduler(number, _POLICY, os.sched_param(priority))
        prioritize_threads()
    except OSError as error:
        logger.warning(
            f'realtime_priority {priority}: {error.strerror}; the loop runs without it. To get '
            'it: the lines "@realtime - rtprio 99" and "@realtime - memlock unlimited" in '
            '/etc/security/limits.conf, your user in the group realtime, a new login')
        return
    if ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT):
        logger.warning(f'realtime_priority {priority}: memory cannot be locked '
                       f'({os.strerror(ctypes.get_errno())}); raise the limit memlock')
    logger.info(f'the loop runs with real-time priority {priority}{_keep_cores_awake()}')


def _keep_cores_awake() -> str:
    """Ask for cores that wake at once, until the process ends; return why they may not."""
    try:
        os.write(os.open(CORE_LATENCY, os.O_WRONLY), bytes(4))  # never closed: closing ends it
    except OSError as error:
        return f'; cores may sleep between periods ({CORE_LATENCY}: {error.strerror})'
    return ''


def prioritize_threads() -> None:
    """Give threads of Python that were started since theirs, where the calling one has one."""
    if os.sched_getscheduler(0) != _POLICY:
        return
    below = os.sched_param(max(1, os.sched_getparam(0).sched_priority - 1))
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and thread.native_id:
            os.sched_setscheduler(thread.native_id, _POLICY, below)


def _receivers() -> list[int]:
    """Return the threads of this process in which messages arrive."""
    return [int(task.name) for task in Path('/proc/self/task').iterdir()
            if (task / 'comm').read_text().startswith(_RECEIVERS)]
