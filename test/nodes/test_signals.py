"""Signals end a node at any time of its start, also while the compiler works."""

import random
import signal
import time
from pathlib import Path

import pytest
from ros_processes import TIMEOUT, wait_until

#: As launch escalates from SIGINT to SIGTERM [s].
LONGEST = 5.0


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('phase', ['imports', 'compiles'])
def test_a_signal_ends_a_node_that_starts(ros, phase, number, tmp_path, times):
    folder = tmp_path / 'cache'
    control = ros.start('control', environment={'NUMBA_CACHE_DIR': str(folder)}, bag='none')
    if phase == 'compiles':
        control.wait_for_line('compiling for this processor')
        time.sleep(random.Random(number).uniform(0.0, 3.0))
    else:
        wait_until(lambda: holds_signals(control.pid), 'a node that listens')
    began = time.monotonic()
    assert control.stop(number) == 0, control.text
    assert time.monotonic() - began < times(TIMEOUT, LONGEST)
    assert 'Traceback' not in control.text
    assert number.name in control.text


def holds_signals(pid: int) -> bool:
    """Return whether a process has come so far as to block SIGINT."""
    status = Path(f'/proc/{pid}/status').read_text()
    masks = dict(line.split(':\t') for line in status.splitlines() if line.startswith('Sig'))
    return bool(int(masks['SigBlk'], 16) & 2)
