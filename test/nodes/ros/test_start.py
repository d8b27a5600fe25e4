"""A node that starts loads what it needs, and nothing that only people at a terminal need."""

import json
import os
import signal
import subprocess
import sys

import pytest
from long_run import resident
from ros_processes import wait_until
from sensor_msgs.msg import JointState

ASK = """
import gc, json, os, signal, sys
from ur5_ros.nodes.ros.start import begin_start
begin_start()
import ur5_ros.nodes.{module}
print(json.dumps({{
    'modules': sorted(sys.modules), 'collects': gc.isenabled(),
    'threads': os.environ['OPENBLAS_NUM_THREADS'],
    'held': [number.name for number in signal.pthread_sigmask(signal.SIG_BLOCK, ())]}}))
"""
FOR_PEOPLE = {'pydantic', 'plotly', 'rich', 'typer', 'viser', 'dask', 'polars'}


def started(module: str, **environment: str) -> dict:
    """Return what a process knows of itself once it has imported a node."""
    printed = subprocess.run(
        [sys.executable, '-c', ASK.format(module=module)], check=True, capture_output=True,
        text=True, env={**os.environ, **environment}).stdout
    return json.loads(printed.splitlines()[-1])


@pytest.mark.parametrize(('module', 'needless'), [
    ('sim.node', FOR_PEOPLE | {'numba', 'scipy'}),
    ('control.node', FOR_PEOPLE | {'pybullet', 'scipy.linalg'}),
])
def test_a_node_loads_nothing_that_it_does_not_need(module, needless):
    assert not needless & set(started(module)['modules'])


def test_signals_wait_and_nothing_is_collected_while_a_node_starts():
    about = started('sim.node')
    assert {'SIGINT', 'SIGTERM', 'SIGHUP'} <= set(about['held'])
    assert not about['collects']


def test_a_users_own_number_of_threads_counts():
    assert started('sim.node', OPENBLAS_NUM_THREADS='3')['threads'] == '3'


def test_a_plain_arm_is_simulated_without_the_compiler():
    code = """
import sys
from ur5_ros.config import SIM_PARAMETERS, complete
from ur5_ros.sim.plant import plant_from_parameters
plant = plant_from_parameters({})
for _ in range(200):
    plant.step(None)  # held by the brake
for _ in range(20):
    plant.step([1.0] * 6)
print('numba' in sys.modules)
"""
    assert subprocess.run([sys.executable, '-c', code], check=True, capture_output=True,
                          text=True).stdout.split() == ['False']


def test_a_node_that_compiles_reports_it_and_a_signal_ends_it(ros, tmp_path):
    node = ros.start('control', environment={'NUMBA_CACHE_DIR': str(tmp_path)})
    node.wait_for_line('compiling for this processor')
    assert node.stop(signal.SIGTERM) == 0, node.text
    assert 'waiting for states' not in node.text
    node = ros.start('control', environment={'NUMBA_CACHE_DIR': str(tmp_path)})
    node.wait_for_line(' compiled in ', 300)


@pytest.mark.parametrize('module', ['sim_node', 'control_node', 'closed_loop'])
def test_nothing_that_starts_threads_is_imported_before_signals_are_blocked(module):
    code = (f'import sys\nimport ur5_ros.nodes.{module}\n'
            'print([name for name in ("numpy", "rclpy", "numba") if name in sys.modules])')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_a_controller_at_work_holds_less_than_200_mib(ros):
    control = ros.start('control', fresh=True)
    commands = ros.observer().subscribe(JointState, '/joint_command')
    ros.start('sim')
    wait_until(lambda: len(commands) > 100, 'a hundred commands')
    assert resident(control.pid) < 200.0


def test_a_kernel_can_be_compiled_after_the_compilers_pages_went_back():
    code = """
from numba import njit
from ur5_ros.nodes.ros.process import release_compiler
twice = njit(lambda x: 2 * x)
assert twice(1) == 2
release_compiler()
assert twice(1.5) == 3.0  # for another type of argument
"""
    subprocess.run([sys.executable, '-c', code], check=True)
