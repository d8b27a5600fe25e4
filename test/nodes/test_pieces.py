"""The parts of the nodes by themselves: names, poses, recordings, requests, sections."""

import resource
import signal
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5_ros.bag.reader import open_bag
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.config.parameter_files import matches, sections
from ur5_ros.control.targets import pose_matrix
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.nodes.ros import background_executor
from ur5_ros.nodes.ros.background_executor import LoopRequests
from ur5_ros.nodes.ros.environment import check_environment
from ur5_ros.nodes.ros.messages import EffortReader, StateReader
from ur5_ros.nodes.ros.process import pin_to_core
from ur5_ros.nodes.ros.recording import Recording, run_of
from ur5_ros.signals import JOINT_NAMES, joint_order


@pytest.mark.parametrize(('section', 'node', 'meant'), [
    ('/ur5_sim', '/ur5_sim', True), ('ur5_sim', '/ur5_sim', True), ('/**', '/a/ur5_sim', True),
    ('/**/ur5_sim', '/a/b/ur5_sim', True), ('/**/ur5_sim', '/ur5_sim', True),
    ('/*/ur5_sim', '/a/ur5_sim', True), ('/*/ur5_sim', '/a/b/ur5_sim', False),
    ('/ur5_sim', '/a/ur5_sim', False), ('/ur5_control', '/ur5_sim', False),
    ('/a/ur5_sim', '/a/ur5_sim', True),
])
def test_sections_of_parameter_files_are_read_as_rcl_reads_them(section, node, meant):
    assert matches(section, node) == meant


@given(st.permutations(JOINT_NAMES))
def test_any_order_of_names_gives_the_same_joints(names):
    values = {name: float(place) for place, name in enumerate(JOINT_NAMES)}
    given_values = np.array([values[name] for name in names])
    assert given_values[joint_order(names, JOINT_NAMES)].tolist() == list(range(6))


@pytest.mark.parametrize(('names', 'printed'), [
    (JOINT_NAMES[:5], 'missing'), (JOINT_NAMES + ('seventh',), 'unknown'),
    (JOINT_NAMES[:5] + JOINT_NAMES[:1], 'twice'), ((), 'missing')])
def test_wrong_names_are_refused_by_name(names, printed):
    with pytest.raises(InputError, match=printed):
        joint_order(names, JOINT_NAMES)


def test_readers_take_their_own_layout_and_any_other_alike():
    numbers = np.arange(1.0, 7.0)
    own = FixedJointState(JOINT_NAMES)
    other = FixedJointState(JOINT_NAMES[::-1], 'some_frame')
    reader = StateReader(JOINT_NAMES)
    for state in (reader.read(own.encode(5, numbers, 2 * numbers, 3 * numbers)),
                  reader.read(other.encode(5, numbers[::-1], 2 * numbers[::-1],
                                           3 * numbers[::-1]))):
        assert state.stamp == 5
        assert state.q.tolist() == numbers.tolist()
        assert state.qd.tolist() == (2 * numbers).tolist()
        assert state.effort.tolist() == (3 * numbers).tolist()
    stamp, names, effort = EffortReader(JOINT_NAMES).read(
        other.encode(7, numbers, numbers, numbers))
    assert (stamp, names, list(effort)) == (7, JOINT_NAMES[::-1], numbers.tolist())


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(
    lambda values: np.linalg.norm(values) > 0.1))
def test_a_pose_comes_back_from_its_quaternion(values):
    quaternion = np.array(values) / np.linalg.norm(values)
    transform = pose_matrix([1.0, 2.0, 3.0], quaternion)
    position, again = position_and_quaternion(transform)
    assert position.tolist() == [1.0, 2.0, 3.0]
    assert again[3] >= 0.0
    assert np.allclose(pose_matrix(position, again), transform, atol=1e-12)


def record(recording, count=3):
    topic = recording.topic('/x', 'sensor_msgs/msg/JointState')
    layout = FixedJointState(JOINT_NAMES)
    for k in range(count):
        recording.write(topic, layout.encode(k + 1, *np.ones((3, 6))))
    return layout


def test_what_comes_before_the_run_has_a_name_is_recorded(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recording = Recording('auto', 'control', 60.0, 0)
    record(recording)
    assert not recording.is_open
    recording.begin('a_run', {'node': 'control'})
    recording.write(1, FixedJointState(JOINT_NAMES).encode(4, *np.ones((3, 6))))
    recording.end({'reason': 'done'})
    bag = open_bag(tmp_path / 'bags' / 'a_run' / 'control')
    assert bag.joint_states('/x').stamp.tolist() == [1, 2, 3, 4]
    assert bag.notes['summary']['reason'] == 'done'
    assert recording.lost == 0


def test_no_recording_is_asked_for_by_an_empty_word(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recording = Recording('', 'sim', 60.0, 0)
    record(recording)
    recording.begin('a_run', {})
    recording.end({})
    assert recording.lost == 0
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_reported_and_ends_no_recording_node(tmp_path):
    recording = Recording(str(tmp_path / 'bag'), 'sim', 60.0, 0)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        topic = recording.topic('/x', 'sensor_msgs/msg/JointState')
        recording.begin('a_run', {})
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
        noise = np.random.default_rng(1)
        layout = FixedJointState(JOINT_NAMES)
        for k in range(2000):
            recording.write(topic, layout.encode(k + 1, *noise.random((3, 6))))
        recording.end({})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)
    assert recording.lost > 0
    assert recording.failure


def test_a_folder_names_its_run(tmp_path):
    assert run_of(str(tmp_path / 'mine' / 'sim'), lambda: 'new') == 'mine'
    assert run_of('auto', lambda: 'new') == 'new'
    with pytest.raises(InputError, match='exists'):
        run_of(str(tmp_path), lambda: 'new')


def test_requests_of_other_threads_are_done_by_the_loop_in_turn():
    woken = threading.Event()
    requests = LoopRequests(woken.set)
    done = []

    def refuse():
        raise InputError('no')

    def ask():
        done.append(requests.call(lambda: threading.get_ident()))
        with pytest.raises(InputError, match='no'):
            requests.call(refuse)
        done.append('refused')

    other = threading.Thread(target=ask)
    other.start()
    while other.is_alive():
        woken.wait(5.0)
        woken.clear()
        requests.serve()
        other.join(0.01)
    assert done == [threading.get_ident(), 'refused']


def test_a_request_that_was_refused_for_its_wait_is_not_done_later(monkeypatch):
    monkeypatch.setattr(background_executor, 'REQUEST_TIMEOUT', 0.05)
    requests, done, answers = LoopRequests(lambda: None), [], []

    def ask(work):
        try:
            answers.append(requests.call(work))
        except InputError as error:
            answers.append(str(error))

    waiting = threading.Thread(target=ask, args=(lambda: done.append('late'),))
    waiting.start()
    waiting.join()
    requests.serve()
    assert done == [] and 'busy' in answers.pop()
    # what was begun in time is waited for, however long it takes
    slow = threading.Thread(target=ask, args=(lambda: time.sleep(0.2) or done.append('slow'),))
    slow.start()
    while slow.is_alive():
        requests.serve()
        time.sleep(0.001)
    assert done == ['slow'] and answers == [None]


@pytest.mark.parametrize('environment', [
    {'ROS_DOMAIN_ID': '-1'}, {'ROS_DOMAIN_ID': '1.5'}, {'ROS_DOMAIN_ID': '300'},
    {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Permissive'},
    {'ROS_SECURITY_ENABLE': 'true'}, {'RCUTILS_LOGGING_USE_STDOUT': 'yes'},
    {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'near'}, {'ROS_STATIC_PEERS': '127.0.0.1;no..host'},
    {'FASTRTPS_DEFAULT_PROFILES_FILE': '/'}, {'FASTDDS_DEFAULT_PROFILES_FILE': '/none.xml'}])
def test_an_environment_that_is_not_what_it_seems_is_refused(environment):
    with pytest.raises(InputError, match=next(iter(environment))):
        check_environment(environment)


def test_a_core_that_is_none_is_refused():
    for core in ('first', '-1', '9999'):
        with pytest.raises(InputError, match='UR5_ROS_CORE'):
            pin_to_core(core)


def test_an_ordinary_environment_serves(repo):
    check_environment({})
    check_environment({'ROS_STATIC_PEERS': '127.0.0.1;localhost', 'RMW_IMPLEMENTATION': '',
                       'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'FASTRTPS_DEFAULT_PROFILES_FILE':
                       str(repo / 'config' / 'fastdds_loopback.xml')})
    check_environment({'ROS_DOMAIN_ID': '', 'ROS_SECURITY_ENABLE': 'false'})
    check_environment({'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce'})


@pytest.mark.parametrize(('text', 'printed'), [
    ('/a: &x\n  ros__parameters: {b: 1}\n/c: *x\n', 'alias'), ('/a:\n  b: 1\n  b: 2\n', 'twice'),
    ('[1, 2]', 'no sections'), ('a: [', 'YAML'), ('a: "b', 'YAML')])
def test_a_parameter_file_that_rcl_reads_otherwise_is_refused(tmp_path, text, printed):
    file = tmp_path / 'parameters.yaml'
    file.write_text(text)
    with pytest.raises(InputError, match=printed):
        sections(file)


def test_values_and_tags_of_a_parameter_file_are_not_looked_at(tmp_path):
    file = tmp_path / 'parameters.yaml'
    file.write_text('/a/b:\n  ros__parameters:\n    x: !!python/tuple [1]\n    y: !mine ~\n'
                    'c:\n  /d:\n    ros__parameters: {}\n')
    assert sections(file) == ['/a/b', '/c/d']
