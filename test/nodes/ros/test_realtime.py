"""Real-time scheduling is for the loop and what it waits for; without the right a node runs on."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ur5_ros.nodes.ros.realtime import CORE_LATENCY

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

WITHOUT_THE_DEVICE = """
from pathlib import Path
from rclpy.logging import get_logger
from ur5_ros.nodes.ros import realtime
realtime.CORE_LATENCY = Path('/dev/no_such_device')
realtime.use_realtime(1, get_logger('node'))
"""


def longest_waking() -> int:
    """Return how long a core may take to wake [us], as the kernel has it now."""
    return int.from_bytes(CORE_LATENCY.read_bytes(), sys.byteorder)


def priorities(pid):
    """Return the priorities of the loop, of the middleware's threads, and of Python's others."""
    found = {'loop': [], 'receiving': [], 'middleware': [], 'python': []}
    for task in Path(f'/proc/{pid}/task').iterdir():
        name, number = (task / 'comm').read_text(), int(task.name)
        part = ('loop' if number == pid else
                'receiving' if name.startswith(('dds.udp', 'dds.shm.7')) else
                'middleware' if name.startswith('dds') else 'python')
        realtime = os.sched_getscheduler(number) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO
        found[part].append(os.sched_getparam(number).sched_priority if realtime else 0)
    found['python'] = sorted(filter(None, found['python']))  # those of a tracer are nobody's
    return found


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may give real-time priorities here')
@pytest.mark.parametrize('node', ['sim', 'control'])
def test_the_loop_has_the_priority_and_what_has_the_interpreter_beside_it_one_less(ros, node):
    process = ros.start(node, realtime_priority=20, bag='')
    process.wait_for_line('runs with real-time priority 20')
    found = priorities(process.pid)
    assert found['loop'] == [20] and set(found['receiving']) == {20}
    assert set(found['middleware']) == {0} and set(found['python']) == {19}
    assert int((Path(f'/proc/{process.pid}/status').read_text().split('VmLck:')[1]).split()[0]) > 0
    assert process.stop() == 0, process.text


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may give real-time priorities here')
def test_bags_are_written_with_a_priority_too_whenever_they_are_opened(ros):
    control = ros.start('control', realtime_priority=20)
    control.wait_for_line('runs with real-time priority 20')
    before = priorities(control.pid)['python']
    sims = {}
    for bag in ('', 'auto'):
        sims[bag] = ros.start('sim', lockstep=False, bag=bag, realtime_priority=20)
        sims[bag].wait_for_line('runs with real-time priority 20')
        sims[bag] = len(priorities(sims[bag].pid)['python'])
        assert ros.processes[-1].stop() == 0
    control.wait_for_line('recording ')
    assert priorities(control.pid)['python'] == [*before, 19]
    assert sims['auto'] == sims[''] + 1
    assert control.stop() == 0, control.text


def test_without_the_right_one_line_names_the_way_and_the_node_runs(ros):
    process = ros.run([sys.executable, '-c', WITHOUT_RIGHTS, '--ros-args', '-p',
                       'realtime_priority:=20', '-p', "bag:=''"])
    process.wait_for_line('waiting for the first command')
    lines = [line for line in process.text.splitlines() if 'realtime_priority 20' in line]
    assert len(lines) == 1 and 'rtprio' in lines[0] and 'limits.conf' in lines[0]
    assert process.stop() == 0, process.text


@pytest.mark.skipif(not os.access(CORE_LATENCY, os.W_OK), reason='no right to keep cores awake')
def test_cores_are_kept_awake_while_a_node_has_a_priority_and_no_longer(ros):
    before = longest_waking()
    process = ros.start('sim', realtime_priority=20, bag='')
    process.wait_for_line('runs with real-time priority 20')
    assert longest_waking() == 0 < before
    assert process.stop() == 0, process.text
    assert longest_waking() == before


@pytest.mark.skipif(os.geteuid() != 0, reason='only root may give real-time priorities here')
def test_where_cores_cannot_be_kept_awake_the_line_says_so():
    done = subprocess.run([sys.executable, '-c', WITHOUT_THE_DEVICE], text=True,
                          capture_output=True, timeout=60)
    assert done.returncode == 0
    assert ('real-time priority 1; cores may sleep between periods (/dev/no_such_device: '
            'No such file or directory)') in done.stderr
