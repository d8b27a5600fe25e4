"""Late periods of a paced run: what /diagnostics reports is what the bag shows."""

import signal
import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.bag.reader import open_bag

#: Control period, and what a busy processor may hold up a step that began in time [ns].
PERIOD, HELD_UP = 4_000_000, 20_000_000


def behind(bag, until):
    """Return how far behind their schedule states were recorded, up to a stamp [ns]."""
    states = bag.joint_states('/joint_states').stamp
    stamp, first = np.unique(states, return_index=True)
    late = bag.columns('/joint_states').log_time[first] - stamp
    late -= np.minimum.accumulate(late[::-1])[::-1]  # the schedule may only move to later
    return late[stamp <= until]


def test_late_periods_on_diagnostics_are_those_of_the_bag(ros):
    sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000)
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    reports = watcher.subscribe(DiagnosticArray, '/diagnostics')
    for _ in range(5):
        count = len(states)
        wait_until(lambda count=count: len(states) > count + 50, 'further states')
        sim.popen.send_signal(signal.SIGSTOP)
        time.sleep(0.06)
        sim.popen.send_signal(signal.SIGCONT)
    count = len(reports)
    wait_until(lambda: len(reports) > count + 1, 'diagnostics after the last stop')
    assert sim.stop() == 0, sim.text
    bag = open_bag(ros.bag('sim'))
    message = [each for _, each in bag.messages('/diagnostics')
               if each['status'][0]['name'].endswith(': simulator')][-1]
    reported = int({each['key']: each['value'] for each in message['status'][0]['values']}
                   ['late_periods'])
    until = message['header']['stamp']
    late = behind(bag, until['sec'] * 10**9 + until['nanosec'])
    surely = int((late > PERIOD / 2 + HELD_UP).sum())
    assert surely >= 5, 'each stop made some periods late'
    assert surely <= reported <= int((late > PERIOD / 2).sum())
