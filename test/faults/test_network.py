"""Strangers on the topics and on the ports: floods, garbage, other types, other machines."""

import os
import random
import re
import shlex
import signal
import socket
import struct
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from nav_msgs.msg import Path as PathMessage
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros_processes import send_until, wait_until
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.reader import open_bag

#: Everything that the two nodes hear.
INPUTS = {
    '/joint_command': JointState, '/forward_effort_controller/commands': Float64MultiArray,
    '/ur5_sim/external_wrench': WrenchStamped, '/ur5_control/target_joints': JointState,
    '/ur5_control/target_pose': PoseStamped, '/ur5_control/joint_trajectory': JointTrajectory,
    '/ur5_control/path': PathMessage,
}


def stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def pair_running(ros, **sim):
    """Start both nodes and wait until the loop turns; return them and the states heard."""
    nodes = ros.start('sim', **sim), ros.start('control')
    states = ros.observer().subscribe(JointState, '/joint_states')
    wait_until(lambda: states and stamp(states[-1]) > 50_000_000, 'fifty periods')
    return *nodes, states


def goes_on(states, periods=200):
    """Wait for more states and check that the arm is sane."""
    began = stamp(states[-1])
    wait_until(lambda: stamp(states[-1]) > began + periods * 1_000_000, 'the loop to go on')
    assert np.isfinite(states[-1].position).all()
    assert np.abs(states[-1].velocity).max() < 2.0


@pytest.mark.timeout(3600)
@pytest.mark.fault(17, 18, 22, 83)
def test_a_flood_of_garbage_on_every_input_does_not_disturb_the_loop(
        ros, times, record_property):
    sim, control, states = pair_running(ros)
    dice = random.Random(17)
    flood = ros.observer('flood')
    publishers = [flood.publisher(kind, topic) for topic, kind in INPUTS.items()]
    rounds = times(1_000, 15_000)
    for _ in range(rounds):
        for publisher in publishers:
            size = dice.choice([0, 3, 4, 12, 60, 300, 5000])
            publisher.publish(b'\x00\x01\x00\x00' + dice.randbytes(size))
    goes_on(states)
    record_property('garbage messages on every input', rounds * len(INPUTS))
    assert control.stop() == 0, control.text
    assert sim.stop() == 0, sim.text
    assert 'Traceback' not in sim.text + control.text
    bag = open_bag(ros.bag('sim'))
    assert np.isfinite(bag.joint_states('/joint_states').position).all()


@pytest.mark.fault(16)
def test_a_message_of_many_megabytes_is_refused_by_its_length(ros):
    sim, control, states = pair_running(ros)
    intruder = ros.observer('huge').publisher(JointState, '/joint_command')
    reported = ros.observer('watcher').subscribe(DiagnosticArray, '/diagnostics')

    def counted():
        return sum(int(pair.value) for message in reported[-20:]
                   for pair in message.status[0].values
                   if pair.key.startswith('refused /joint_command'))

    for length, bytes_of_it in ((20_000, 320_036), (500_000, 8_000_036)):
        before = counted()
        huge = JointState(name=['x'] * length, effort=[0.0] * length)
        send_until(lambda huge=huge: intruder.publish(huge),
                   lambda before=before, size=bytes_of_it: counted() > before
                   and f'{size} bytes; at most 65536 are read' in sim.text,
                   f'{length} names, counted and told')
        goes_on(states)
    assert sim.stop() == 0
    assert control.stop() == 0
    assert sum(file.stat().st_size for file in ros.bag('sim').iterdir()) < 5_000_000


@pytest.mark.fault(14, 15)
def test_publishers_that_do_not_fit_do_no_harm(ros):
    sim, control, states = pair_running(ros)
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    timid = ros.observer('timid').node.create_publisher(JointState, '/joint_command', best_effort)
    other = ros.observer('other').node.create_publisher(String, '/joint_command', 10)
    for _ in range(100):
        timid.publish(JointState())
        other.publish(String(data='not a command'))
    goes_on(states)
    assert sim.stop() == 0
    assert control.stop() == 0


@pytest.mark.fault(82)
def test_every_socket_of_both_nodes_is_on_the_loopback_interface(ros):
    sim, control, _ = pair_running(ros)
    assert_private([sim.pid, control.pid])


@pytest.mark.fault(82)
def test_every_socket_of_the_demo_is_on_the_loopback_interface(ros):
    for name in ('FASTRTPS_DEFAULT_PROFILES_FILE', 'ROS_DOMAIN_ID'):
        del ros.environment[name]  # the command itself sees to it
    demo = ros.run([sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'demo'])

    def nodes():
        return [child.pid for child in psutil.Process(demo.pid).children(recursive=True)
                if any('_node' in word for word in child.cmdline())]

    wait_until(lambda: len(list((ros.folder / 'bags').glob('*/*/*.mcap'))) == 2, 'both bags')
    assert_private([demo.pid, *nodes()])
    demo.popen.send_signal(signal.SIGINT)
    demo.ends()


@pytest.mark.fault(82)
@pytest.mark.parametrize('name', ['sim', 'closed_loop', 'rviz'])
def test_every_launch_file_sets_the_loopback_profile(repo, name):
    text = (repo / 'launch' / f'{name}.launch.py').read_text()
    assert 'loopback' not in text.split('ARGUMENTS = {')[1].split('\n}\n')[0]
    assert 'return describe(ARGUMENTS, nodes)' in text
    shared = (repo / 'ur5_ros' / 'launcher' / 'launch_file.py').read_text()
    assert "_NETWORK = {'loopback': Argument('true'," in shared
    assert 'arguments = {**arguments, **_NETWORK}' in shared
    assert "*_network(values['loopback'])" in shared
    assert re.search(r"SetEnvironmentVariable\(\s*'FASTRTPS_DEFAULT_PROFILES_FILE',\s*"
                     r"str\(config_folder\(\) / 'fastdds_loopback.xml'\)\)", shared)


def assert_private(pids) -> None:
    """Check that no process has a socket that another machine could reach."""
    found = 0
    for pid in pids:
        for address in udp_and_tcp_addresses(pid):
            found += 1
            if socket.inet_aton(address)[0] >> 4 == 14:  # multicast: heard where it is joined
                assert interfaces_joined(pid, address) <= {'lo'}
            else:
                assert address.startswith('127.'), f'{address} is open to the network'
    assert found >= 4


def interfaces_joined(pid: int, group: str) -> set[str]:
    """Return the network interfaces on which a multicast group is joined."""
    packed = f'{int.from_bytes(socket.inet_aton(group), "little"):08X}'
    joined, device = set(), ''
    for line in Path(f'/proc/{pid}/net/igmp').read_text().splitlines()[1:]:
        if not line[0].isspace():
            device = line.split()[1]
        elif line.split()[0] == packed:
            joined.add(device)
    return joined


def udp_and_tcp_addresses(pid: int) -> list[str]:
    """Return the local address of every UDP and TCP socket of a process."""
    inodes = set()
    for link in Path(f'/proc/{pid}/fd').iterdir():
        target = re.match(r'socket:\[(\d+)\]', str(link.readlink()))
        if target:
            inodes.add(target[1])
    addresses = []
    for table in ('udp', 'tcp', 'udp6', 'tcp6'):
        for line in Path(f'/proc/{pid}/net/{table}').read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes:
                packed = bytes.fromhex(fields[1].partition(':')[0])
                assert len(packed) == 4, f'an IPv6 socket is open: {line}'
                addresses.append(socket.inet_ntoa(struct.pack('<I', int.from_bytes(packed))))
    return addresses


@pytest.mark.fault(81)
def test_random_packets_on_the_middlewares_ports_do_not_stop_the_loop(ros, times, record_property):
    sim, control, states = pair_running(ros)
    first = 7400 + 250 * ros.domain
    dice = random.Random(81)
    sent = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        end = time.monotonic() + times(2.0, 60.0)
        while time.monotonic() < end:
            head = b'RTPS\x02\x03\x01\x0f' if dice.random() < 0.5 else b''
            data = head + dice.randbytes(dice.choice([0, 8, 40, 200, 1400]))
            sender.sendto(data, ('127.0.0.1', first + dice.choice([0, 1, 10, 11, 12, 13])))
            sent += 1
    goes_on(states)
    record_property('hostile packets survived', sent)
    assert sim.stop() == 0
    assert control.stop() == 0
    assert sent > 1000


@pytest.mark.fault(62)
def test_a_robot_in_another_domain_receives_nothing(ros, tmp_path):
    from ros_processes import ros_domain
    _, _, states = pair_running(ros)
    (tmp_path / 'other').mkdir()
    with ros_domain(tmp_path / 'other') as other:
        assert other.domain != ros.domain
        stranger = other.observer('stranger')
        received = stranger.subscribe(JointState, '/joint_states', publishers=0)
        goes_on(states, 1000)
        assert received == []
        assert 'ur5_sim' not in stranger.node.get_node_names()


@pytest.mark.fault(61)
def test_two_simulators_under_one_name_are_reported_and_damage_no_recording(ros):
    first, control, states = pair_running(ros)
    second = ros.start('sim')
    second.wait_for_line('recorded in')
    goes_on(states, 1000)
    control.wait_for_line('keep one of them')
    for process in (second, first, control):
        assert process.stop() == 0, process.text
    for bag in (ros.folder / 'bags').glob('*/sim'):
        assert open_bag(bag).check() == []
    judged = [validate(load_run(bag.parent)) for bag in (ros.folder / 'bags').glob('*/control')]
    assert judged
    for result in judged:
        assert result.passed or result.causes[0]['kind'] == 'two simulators', result.causes


@pytest.mark.fault(63)
def test_full_shared_memory_is_no_reason_to_stop(ros):
    unshare = ['unshare', '-m'] if os.geteuid() == 0 else ['unshare', '-rm']
    inner = 'mount -t tmpfs -o size=64k tmpfs /dev/shm && exec ' + shlex.join(
        [sys.executable, '-m', 'ur5_ros.nodes.sim_node', '--ros-args', '-p', 'stop_after:=0.5'])
    sim = ros.run([*unshare, 'sh', '-c', inner])
    control = ros.start('control')
    assert sim.ends(120) == 0, sim.text
    assert control.stop() == 0
    assert len(open_bag(ros.bag('sim')).joint_states('/joint_states').stamp) == 500
