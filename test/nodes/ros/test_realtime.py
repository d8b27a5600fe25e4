"""Real-time scheduling is the loop's alone, and a node without the right runs on without it."""

import os
import sys
from pathlib import Path

import pytest

WITHOUT_RIGHTS = """
import resource, sys
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
import ctypes
libc = ctypes.CDLL(None, use_errno=True)
PR_CAPBSET_DROP, CAP_SYS_NICE = 24, 23
assert libc.prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0) == 0
import os
os.execv(sys.executable, [sys.executable, '-m', 'ur5_ros.nodes.sim_node', *sys.argv[1:]])
"""


def policies(pid):
    """Return the scheduling policies of the loop, of the receiving threads, and of the others."""
    found = {'loop': set(), 'receiving': set(), 'other': set()}
    for task in Path(f'/proc/{pid}/task').iterdir():
        name = (task / 'comm').read_text()
        part = ('loop' if task.name == str(pid) else
                'receiving' if name.startswith(('dds.udp', 'dds.shm.7')) else 'other')
        found[part].add(os.sched_getscheduler(int(task.name)) & ~os.SCHED_RESET_ON_FORK)
    return found


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may give real-time priorities here')
@pytest.mark.parametrize('node', ['sim', 'control'])
def test_the_loop_and_what_hands_it_messages_have_the_priority_and_nothing_else(ros, node):
    process = ros.start(node, realtime_priority=20, bag='')
    process.says('runs with real-time priority 20')
    assert policies(process.pid) == {'loop': {os.SCHED_FIFO}, 'receiving': {os.SCHED_FIFO},
                                     'other': {os.SCHED_OTHER}}
    assert int((Path(f'/proc/{process.pid}/status').read_text().split('VmLck:')[1]).split()[0]) > 0
    assert process.stop() == 0, process.text


def test_without_the_right_one_line_names_the_way_and_the_node_runs(ros):
    process = ros.run([sys.executable, '-c', WITHOUT_RIGHTS, '--ros-args', '-p',
                       'realtime_priority:=20', '-p', "bag:=''"])
    process.says('waiting for the first command')
    lines = [line for line in process.text.splitlines() if 'realtime_priority 20' in line]
    assert len(lines) == 1 and 'rtprio' in lines[0] and 'limits.conf' in lines[0]
    assert process.stop() == 0, process.text
