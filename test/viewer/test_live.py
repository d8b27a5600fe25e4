"""The live view follows a running simulator and asks nothing of it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.config import config_folder
from ur5_ros.errors import InputError
from ur5_ros.viewer import view
from ur5_ros.viewer.live import LiveView

SIMULATOR = [
    Path(sys.executable).parent / 'sim_node', '--ros-args', '-p', 'arm:=ur10e', '-p', "bag:=''",
    '-p', 'lockstep:=false', '-p', 'fallback:=zero_torque', '-p', 'tf_prefix:=left_']


@pytest.fixture
def network(monkeypatch):
    """Give this test a domain of its own on 127.0.0.1."""
    monkeypatch.setenv('ROS_DOMAIN_ID', '176')
    monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE',
                       str(config_folder() / 'fastdds_loopback.xml'))
    monkeypatch.delenv('ROS_AUTOMATIC_DISCOVERY_RANGE', raising=False)


@pytest.fixture
def simulator(network, tmp_path):
    """Return a running simulator whose arm falls."""
    process = subprocess.Popen([str(word) for word in SIMULATOR], cwd=tmp_path,
                               env=dict(os.environ), stdin=subprocess.DEVNULL,
                               stderr=subprocess.STDOUT,
                               stdout=(tmp_path / 'simulator.log').open('w'))
    yield process
    process.send_signal(signal.SIGINT)
    process.wait(timeout=20)


def test_the_live_view_draws_the_arm_that_runs_where_it_is(simulator):
    shown = LiveView(18340)
    try:
        seen, end = [], time.monotonic() + 60
        while len(seen) < 20 and time.monotonic() < end:
            if shown.update():
                seen.append(shown.newest)
            time.sleep(0.02)
    finally:
        shown.close()
    assert len(seen) == 20
    assert [sample.t for sample in seen] == sorted({sample.t for sample in seen})
    moved = np.abs(seen[-1].q - seen[0].q).max()
    assert moved > 1e-3, 'the arm falls under zero torque'
    assert shown.tree.root == 'left_base_link'
    reach = sum(np.linalg.norm(joint.pose[:3, 3]) for joint in shown.tree.joints)
    assert reach > 1.3, 'a ur10e, as /robot_description says, not the default ur5'


def test_the_live_view_names_what_is_added_to_the_plant_while_it_looks(simulator, tmp_path):
    shown = LiveView(18342)
    try:
        end = time.monotonic() + 60
        while not shown.update() and time.monotonic() < end:
            time.sleep(0.02)
        command = Path(sys.executable).parent / 'ur5'
        subprocess.run([command, 'set', '/ur5_sim', 'payload.mass', '2.0'], cwd=tmp_path,
                       check=True, timeout=60, capture_output=True)
        while 'payload.mass 2' not in shown.page.curves.added.content and time.monotonic() < end:
            shown.update()
            time.sleep(0.02)
        added, = shown.injected
        assert added.text == 'payload.mass 2'
        assert 0.0 < added.t <= shown.newest.t
        assert f'1. from {added.t:.4g} s: payload.mass 2' in shown.page.curves.added.content
    finally:
        shown.close()


def test_the_live_view_ends_on_sigterm(simulator, tmp_path):
    code = 'from ur5_ros.cli import main; main()'
    process = subprocess.Popen([sys.executable, '-c', code, 'view', '--live', '--port', '0'],
                               cwd=tmp_path, env=dict(os.environ), stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        for line in process.stdout:
            if 'http://' in line:
                break
        time.sleep(1.0)
        process.terminate()
        assert process.wait(timeout=20) == 0
    finally:
        process.kill()
        process.wait()


def test_live_and_a_run_together_are_refused():
    with pytest.raises(InputError, match='leave out the run'):
        view(Path('bags/some'), live=True)
