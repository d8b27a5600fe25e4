"""What a running node needs is compiled while it starts: no period waits for the compiler."""

import sys
import time

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, WrenchStamped
from nav_msgs.msg import Path
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

#: A node that prints every kernel that is compiled once it has started.
REPORTS = """
import sys
from ur5_ros.nodes.ros.start import begin_start
stop = begin_start()
from ur5_ros.model.kernels.compile_notice import on_compile
from ur5_ros.nodes.{module} import {name}
from ur5_ros.nodes.ros.process import run_node

def create(files, stop):
    node = {name}(files, stop)
    print('with Numba' if 'numba' in sys.modules else 'without Numba', flush=True)
    on_compile(lambda kernel: print('compiled late:', kernel, flush=True))
    return node

run_node(create, stop)
"""
#: Longest pause of a paced simulator on a busy machine [s]; a kernel takes seconds.
LONGEST_GAP = 1.5


@pytest.fixture
def cold(ros):
    """Start a node with an empty cache of kernels."""
    def start(module, name, *parameters):
        return ros.run(
            [sys.executable, '-c', REPORTS.format(module=module, name=name), '--ros-args',
             *(word for each in parameters for word in ('-p', each))],
            {'NUMBA_CACHE_DIR': str(ros.folder / 'cache')})
    return start


def test_a_paced_simulator_takes_wrenches_and_brakes_without_the_compiler(ros, cold):
    """Wall time goes on: a wrench that had to be compiled held the states up for seconds."""
    sim = cold('sim.node', 'SimNode', 'lockstep:=false', 'control_rate:=250',
               'physics_rate:=1000', 'effort_convention:=gravity_excluded', 'bag:=none')
    watcher, times, states = ros.observer(), [], []
    watcher.subscribe(JointState, '/joint_states', react=lambda state: (
        times.append(time.monotonic()), states.append(state)))
    torques = watcher.publisher(Float64MultiArray, '/forward_effort_controller/commands')
    wrenches = watcher.publisher(WrenchStamped, '/ur5_sim/external_wrench')
    wait_until(lambda: len(times) > 100, 'states')
    wrench = WrenchStamped()
    wrench.header.frame_id, wrench.wrench.force.x = 'tool0', 20.0
    wrenches.publish(wrench)
    still = Float64MultiArray(data=[0.0] * 6)
    wait_until(lambda: torques.publish(still) or np.abs(states[-1].velocity).max() > 0.2,
               'the wrench to move the arm')
    wait_until(lambda: np.abs(states[-1].velocity).max() < 1e-3, 'the brake to stop it')
    assert 'compiling for this processor' in sim.text
    assert 'compiled late' not in sim.text, sim.text
    assert np.diff(times).max() < LONGEST_GAP
    assert sim.stop() == 0, sim.text


def test_a_simulator_in_lockstep_takes_a_wrench_without_the_compiler(ros, cold):
    """The first wrench was compiled in the loop; once compiled, a start loads nothing for it."""
    parameters = ('control_rate:=250', 'physics_rate:=1000', 'bag:=none')
    sim = cold('sim.node', 'SimNode', *parameters)
    sim.wait_for_line('waiting for the first command', 300)
    control = ros.start('control', bag='none')
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: len(states) > 20, 'states')
    before: list[np.ndarray] = []
    for frame in ('base', 'tool0'):
        wrench = WrenchStamped()
        wrench.header.frame_id, wrench.wrench.force.x = frame, 20.0
        before.append(np.array(states[-1].position))
        watcher.publisher(WrenchStamped, '/ur5_sim/external_wrench').publish(wrench)
        wait_until(lambda: np.abs(states[-1].position - before[-1]).max() > 1e-3,
                   'the wrench to move the arm')
    assert 'compiling for this processor' in sim.text
    assert 'compiled late' not in sim.text, sim.text
    assert sim.stop() == 0, sim.text
    sim = cold('sim.node', 'SimNode', *parameters)
    sim.wait_for_line('without Numba')
    assert sim.stop() == 0 and control.stop() == 0


def test_a_controller_monitors_plans_and_guards_without_the_compiler(ros, cold):
    """The first diagnostics of a cold start said "no state for 1.7 s"."""
    control = cold('control.node', 'ControlNode', 'bag:=none')
    control.wait_for_line('waiting for states', 300)
    sim = ros.start('sim', lockstep=False, control_rate=250, physics_rate=1000, bag='none',
                    command_timeout=5.0)
    watcher = ros.observer()
    poses = watcher.subscribe(PoseStamped, '/ur5_control/tool_pose')
    wait_until(lambda: poses, 'the monitor')
    target = PoseStamped()
    target.header.frame_id, target.pose = 'base', poses[-1].pose
    target.pose.position.z += 0.02
    for topic, message in (('target_pose', target), ('path', Path(poses=[target]))):
        message.header.frame_id = 'base'
        watcher.publisher(type(message), f'/ur5_control/{topic}').publish(message)
    push = WrenchStamped()
    push.header.frame_id, push.wrench.force.z = 'tool0', 1.0
    watcher.publisher(WrenchStamped, '/ur5_control/target_wrench').publish(push)
    wait_until(lambda: abs(poses[-1].pose.position.z - target.pose.position.z) < 2e-3,
               'the tool at its target')
    assert watcher.call(Trigger, '/ur5_control/hold').success
    assert 'compiled late' not in control.text, control.text
    assert 'no state for' not in control.text, control.text
    assert control.stop() == 0 and sim.stop() == 0, control.text
