"""The simulator in a world, on its topics and services."""

import json

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, WrenchStamped
from ros_processes import wait_until
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from ur5_ros.analysis.data.load import load_run
from ur5_ros.bag.reader import open_bag
from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.worlds import load_world
from ur5_ros.control.experiment import initial_positions
from ur5_ros.signals import JOINT_NAMES

START = initial_positions(load_experiment('push_block'), load_arm('ur5')).tolist()


def test_contact_is_published_recorded_and_zeroed(ros):
    watcher = ros.observer()
    simulator = ros.start('sim', world='blocks', lockstep=False, initial_positions=START,
                          force_torque__offset=[1.0, 2.0, 3.0, 0.0, 0.0, 0.0])
    wrenches = watcher.subscribe(WrenchStamped, '/force_torque_sensor_broadcaster/wrench')
    efforts = watcher.subscribe(JointState, '/ur5_sim/contact_effort')
    markers = watcher.subscribe(MarkerArray, '/ur5_sim/contacts')
    objects = watcher.subscribe(PoseArray, '/ur5_sim/objects')
    description = watcher.subscribe(String, '/robot_description', kept=True)
    reported = watcher.subscribe(DiagnosticArray, '/ur5_sim/events')
    wait_until(lambda: wrenches and efforts and objects and len(markers) > 5, 'contact topics')
    assert wrenches[-1].header.frame_id == 'tool0'
    force = wrenches[-1].wrench.force
    assert (force.x, force.y, force.z) == (1.0, 2.0, 3.0)
    assert list(efforts[-1].name) == list(JOINT_NAMES) and len(efforts[-1].effort) == 6
    place = objects[-1].poses[0].position
    assert objects[-1].header.frame_id == 'base'
    assert np.allclose([place.x, place.y, place.z], [-0.5, 0.0, 0.05], atol=1e-5)
    arrows = [marker for marker in markers[-1].markers if marker.ns == 'table / block']
    length = sum(arrow.points[1].z - arrow.points[0].z for arrow in arrows[::2])
    assert abs(length + 0.01 * 9.81) < 1e-3, 'blue arrows: the weight of the block on the table'
    wait_until(lambda: description, 'the description')
    assert '<collision>' in description[-1].data
    answer = watcher.call(Trigger, '/ur5_sim/zero_force_torque_sensor')
    assert answer.success, answer.message
    wait_until(lambda: wrenches[-1].wrench.force.x == 0.0, 'a wrench of zero')
    wait_until(lambda: any(each.status[0].name == 'force_torque_sensor' for each in reported),
               'an event')
    assert simulator.stop() == 0
    bag = open_bag(ros.bag('sim'))
    assert not bag.check()
    assert bag.counts()['/ur5_sim/contact_effort'] > 0
    run = load_run(ros.bag('sim'))
    assert run.sim.world == load_world('blocks')
    assert run.contact.shape[1:] == (1, 6) and len(run.objects) > 0


def test_without_a_world_there_is_no_force_sensor(ros):
    watcher = ros.observer()
    ros.start('sim')
    answer = watcher.call(Trigger, '/ur5_sim/zero_force_torque_sensor')
    assert not answer.success
    assert 'set the parameter world' in answer.message
    names = [name for name, _ in watcher.node.get_topic_names_and_types()]
    assert '/ur5_sim/contact_effort' not in names


def test_a_world_that_does_not_fit_ends_the_node_in_one_line(ros):
    simulator = ros.start('sim', world='wall', initial_positions=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert simulator.ends() == 2
    last = simulator.text.strip().splitlines()[-1]
    assert 'overlap by' in last or 'world wall' in last, last
    unknown = ros.start('sim', world='moon')
    assert unknown.ends() == 2
    assert 'unknown world' in unknown.text
    assert json.dumps(unknown.text).count('Traceback') == 0
