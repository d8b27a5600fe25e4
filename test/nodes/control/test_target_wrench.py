"""A desired wrench by topic: the tool presses with it, and other modes refuse it."""

import numpy as np
from geometry_msgs.msg import WrenchStamped
from ros_processes import send_until

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import experiment_trajectory

#: The finger 1 mm over the table.
SPEC = load_experiment('press_and_slide')
MOTION = experiment_trajectory(SPEC, load_arm('ur5'), 1000, 0.02).trajectory
START = MOTION.at(960_000_000).q.tolist()


def wrench(force: float, frame: str = 'base') -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.z = force
    return message


def test_the_tool_presses_with_the_desired_wrench(ros):
    watcher = ros.observer()
    bags = [str(ros.folder / 'run' / node) for node in ('sim', 'control')]
    sim = ros.start('sim', world='table', initial_positions=START, bag=bags[0])
    control = ros.start('control', mode='cartesian_impedance', bag=bags[1])
    felt = watcher.subscribe(WrenchStamped, '/force_torque_sensor_broadcaster/wrench')
    publisher = watcher.publisher(WrenchStamped, '/ur5_control/target_wrench')
    send_until(lambda: publisher.publish(wrench(-20.0)),
               lambda: felt and felt[-1].wrench.force.z < -15.0, 'a press of 20 N')
    assert felt[-1].header.frame_id == 'tool0'
    send_until(lambda: publisher.publish(wrench(10.0, 'tool0')),
               lambda: felt[-1].wrench.force.z > -12.0, 'a press of 10 N')
    assert sim.stop() == 0 and control.stop() == 0
    run = load_run(ros.folder / 'run')
    assert {round(float(each.wrench[2]), 3) for each in run.target_wrenches} == {-20.0, -10.0}
    check = validate(run).check('law')
    assert check.verdict == 'pass' and check.value < 1e-9, check.sentence
    known = np.isfinite(run.command).all(axis=1)
    assert run.target_wrench_at(np.flatnonzero(known)).any(axis=1).sum() > 10


def test_another_mode_refuses_a_wrench(ros):
    watcher = ros.observer()
    ros.start('sim', initial_positions=START)
    control = ros.start('control')
    publisher = watcher.publisher(WrenchStamped, '/ur5_control/target_wrench')
    send_until(lambda: publisher.publish(wrench(-20.0)),
               lambda: 'set mode to cartesian_impedance first' in control.text, 'a refusal')
