"""Gains changed on the running node: the bag tells, and the run is judged by those in force."""

import signal

import numpy as np
import pytest
from ros_processes import wait_until
from sensor_msgs.msg import JointState

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.laws import laws_of
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.recovery import recover
from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import initial_positions
from ur5_ros.loop.repeat import recontrol

START = initial_positions(load_experiment('kebria_fig11'), load_arm('ur5')).tolist()


def change(watcher, **values):
    """Change live parameters of the controller."""
    result = watcher.set_parameters('ur5_control', **values)
    assert result.successful, result.reason


def later(states, periods=150):
    """Wait until the run has gone on for some states."""
    received = len(states)
    wait_until(lambda: len(states) > received + periods, f'{periods} states more')


def start(ros, **more):
    """Start both nodes on the paper's experiment, at a pace in which a service has its time."""
    sim = ros.start('sim', lockstep=False, control_rate=250, initial_positions=START,
                    command_timeout=1.0, bag=str(ros.folder / 'run' / 'sim'), **more)
    control = ros.start('control', experiment='kebria_fig11', autostart=True,
                        bag=str(ros.folder / 'run' / 'control'))
    watcher = ros.observer()
    states = watcher.subscribe(JointState, '/joint_states')
    wait_until(lambda: states and np.abs(states[-1].velocity).max() > 0.02, 'an arm in motion')
    return sim, control, watcher, states


def test_a_run_with_gains_changed_live_is_judged_by_those_in_force(ros):
    sim, control, watcher, states = start(ros)
    for values in ({'kp': [40.0], 'kd': [14.0]}, {'kd': [20.0] * 6}):
        later(states)
        change(watcher, **values)
    later(states)
    assert sim.stop() == 0 and control.stop() == 0
    run = load_run(ros.folder / 'run')
    laws = laws_of(run)
    assert [(law.gains.kp[0, 0], law.gains.kd[0, 0]) for law in laws] == [
        (10.0, 10.0), (40.0, 14.0), (40.0, 20.0)]
    assert all(law.end - law.first > 100 for law in laws)
    result = validate(run)
    check = result.check('law')
    assert check.verdict == 'pass' and check.value < 1e-9, check.sentence
    assert result.check('gains').verdict != 'fail', result.check('gains').sentence
    # the bag of the controller alone, its own states in it, gives the same commands
    found = recontrol(load_run(ros.folder / 'run' / 'control'))
    assert found.equal, found.sentence


@pytest.mark.fault(11)
def test_the_changes_survive_a_kill_and_the_repair_of_the_bag(ros):
    sim, control, watcher, states = start(ros)
    later(states)
    change(watcher, kp=[40.0], kd=[14.0])
    later(states)
    control.popen.send_signal(signal.SIGKILL)
    control.popen.wait()
    assert sim.stop() == 0
    recover(ros.folder / 'run' / 'control', ros.folder / 'mended')
    for folder in (ros.folder / 'run', ros.folder / 'mended'):
        run = load_run(folder)
        assert [law.gains.kp[0, 0] for law in laws_of(run)] == [10.0, 40.0]
        assert validate(run).check('law').verdict == 'pass'
    assert open_bag(ros.folder / 'mended').notes['parameter_changes']
