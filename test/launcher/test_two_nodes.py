"""The two nodes and the loop record the same run: every topic, every byte, whatever the load."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from thorough import times

from ur5_ros.analysis.data.load import load_run
from ur5_ros.bag.reader import open_bag
from ur5_ros.errors import InputError
from ur5_ros.launcher.node_processes import (
    NodeProcesses,
    claim_domain,
    free_domain,
    private_environment,
)
from ur5_ros.launcher.progress import BagGrowth
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.run_config import run_config

#: Topics whose content depends on the wall clock or on the run's name.
OWN = {'/diagnostics', '/ur5_sim/run'}


@pytest.fixture(scope='module', params=['two processes', 'one process'])
def both(request, tmp_path_factory):
    """The same plan recorded by the nodes, beside a busy loop, and by the loop."""
    folder = tmp_path_factory.mktemp('runs')
    plan = run_config(duration=1.5)
    busy = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
    reported = []
    try:
        (folder / 'nodes').mkdir()
        seconds = run_two_nodes(plan, folder / 'nodes', reported.append,
                                request.param == 'one process')
    finally:
        busy.kill()
        busy.wait()
    assert seconds > 0.0 and reported == sorted(reported) and all(each <= 1.5 for each in reported)
    run_closed_loop(plan, folder / 'loop')
    return folder / 'nodes', folder / 'loop'


@pytest.mark.parametrize('side', ['sim', 'control'])
def test_both_record_the_same_bytes_on_every_topic(both, side):
    nodes, loop = (open_bag(folder / side) for folder in both)
    assert nodes.topics == loop.topics
    for topic in nodes.topics.keys() - OWN:
        a, b = nodes.columns(topic), loop.columns(topic)
        assert a.offsets.tolist() == b.offsets.tolist(), topic
        assert a.data.tobytes() == b.data.tobytes(), topic
    assert len(nodes.columns('/joint_states').log_time) == 1500
    assert nodes.notes['summary']['hashes'] == loop.notes['summary']['hashes']


@pytest.mark.parametrize('side', ['sim', 'control'])
def test_both_describe_the_run_alike(both, side):
    nodes, loop = (open_bag(folder / side).description for folder in both)
    assert nodes.keys() == loop.keys()
    assert {key for key in nodes if nodes[key] != loop[key]} == {'run', 'parameters'}
    profiles = []
    for folder in both:
        bag = yaml.safe_load((folder / side / 'metadata.yaml').read_text())
        topics = bag['rosbag2_bagfile_information']['topics_with_message_count']
        profiles.append({topic['topic_metadata']['name']: topic['topic_metadata']
                         for topic in topics})
    assert profiles[0] == profiles[1]


def test_growth_counts_the_states_of_a_finished_bag(both):
    assert BagGrowth(both[1] / 'sim').messages() == 1500
    assert BagGrowth(both[1] / 'nowhere').messages() == 0


def test_growth_stops_at_what_is_not_yet_written(both, tmp_path):
    whole = (both[1] / 'sim' / 'sim_0.mcap').read_bytes()
    growth, counts = BagGrowth(tmp_path), []
    for share in (0.0, 0.3, 0.6, 1.0):
        (tmp_path / 'sim_0.mcap').write_bytes(whole[:int(len(whole) * share)])
        counts.append(growth.messages())
    assert counts == sorted(counts) and counts[0] == 0 and counts[-1] == 1500
    assert 0 < counts[1] < counts[2] < 1500


@pytest.mark.parametrize('composed', [False, True])
def test_a_node_that_ends_early_is_reported_with_its_own_words(composed, tmp_path):
    plan = run_config(duration=0.5)
    plan = plan._replace(control=plan.control.replaced({'experiment': 'fig12'}))
    with pytest.raises(InputError, match='fig12'):
        run_two_nodes(plan, tmp_path, composed=composed)
    log = 'closed_loop.log' if composed else 'control.log'
    assert 'fig12' in (tmp_path / log).read_text()


def test_children_end_with_their_parent_even_when_it_is_killed(tmp_path):
    code = ('import sys, time\nfrom pathlib import Path\n'
            'from ur5_ros.launcher.node_processes import NodeProcesses\n'
            f'nodes = NodeProcesses(Path({str(tmp_path)!r})).__enter__()\n'
            'nodes.start("sim", "ur5_ros.nodes.sim_node", {"bag": ""})\n'
            'print(nodes.pid("sim"), flush=True)\ntime.sleep(60)\n')
    parent = subprocess.Popen([sys.executable, '-c', code], stdout=subprocess.PIPE, text=True)
    child = Path('/proc') / parent.stdout.readline().strip()
    try:
        assert child.exists()
    finally:
        parent.kill()
        parent.wait()
        parent.stdout.close()
    end = time.monotonic() + 30.0
    while child.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not child.exists()


def test_every_child_is_ended_with_the_block(tmp_path):
    with NodeProcesses(tmp_path) as nodes:
        nodes.environment['PYTHONPATH'] = os.pathsep.join(sys.path)
        nodes.start('sim', 'ur5_ros.nodes.sim_node', {'bag': ''})
        assert nodes.poll('sim') is None
    assert nodes.poll('sim') is not None


def test_the_network_is_private(monkeypatch):
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    environment = private_environment()
    assert 1 <= int(environment['ROS_DOMAIN_ID']) <= 101
    assert '127.0.0.1' in Path(environment['FASTRTPS_DEFAULT_PROFILES_FILE']).read_text()
    assert 'ROS_AUTOMATIC_DISCOVERY_RANGE' not in environment
    monkeypatch.setenv('ROS_DOMAIN_ID', '77')
    assert private_environment()['ROS_DOMAIN_ID'] == '77'


def test_a_domain_in_use_is_not_taken():
    import socket
    domain = free_domain()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(('127.0.0.1', 7400 + 250 * domain + 10))
        assert all(free_domain() != domain for _ in range(300))


def test_those_who_start_at_the_same_time_get_different_domains():
    held = [claim_domain() for _ in range(20)]
    try:
        assert len({domain for domain, _ in held}) == 20
        assert all(free_domain() not in {domain for domain, _ in held} for _ in range(100))
    finally:
        for _, claim in held:
            claim.close()


@pytest.fixture
def crowded():
    """A busy loop for each core, as long as a test runs."""
    busy = [subprocess.Popen([sys.executable, '-c', 'while True: pass'])
            for _ in range(os.cpu_count() or 1)]
    yield
    for each in busy:
        each.kill()
        each.wait()


@pytest.mark.parametrize(('experiment', 'seconds', 'rate'), times(
    [('tap_wall', 0.8, 2000)],
    [('tap_wall', 2.0, 4000), ('push_block', 2.5, 1000), ('press_and_slide', 5.0, 1000),
     ('peg_in_hole', 4.0, 1000)]))
@pytest.mark.thorough
def test_contact_is_recorded_alike_to_the_bit_by_both_ways_beside_other_nodes_and_by_the_loop(
        experiment, seconds, rate, tmp_path, crowded):
    plan = run_config(experiment, duration=seconds, physics_rate=rate)
    for name in ('two processes', 'one process'):
        (tmp_path / name).mkdir()
        run_two_nodes(plan, tmp_path / name, composed=name == 'one process')
    for name in ('loop', 'loop again'):
        run_closed_loop(plan, tmp_path / name)
    bags = [open_bag(folder / 'sim') for folder in sorted(tmp_path.iterdir())]
    assert len(bags) == 4
    for bag in bags[1:]:
        assert bag.topics == bags[0].topics
        for topic in bag.topics.keys() - OWN:
            data = bag.columns(topic).data.tobytes()
            assert data == bags[0].columns(topic).data.tobytes(), topic
    contact = load_run(tmp_path / 'loop').contact
    assert contact.any() and contact.shape == (round(1000 * seconds), rate // 1000, 6)
