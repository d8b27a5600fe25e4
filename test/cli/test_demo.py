"""The demo: two nodes, one verdict; it repeats, it names what is wrong, it leaves no process."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ur5_ros.config import arm_text, config_folder

SHORT = 'duration: 1.5\nramp: 1.5\n'


@pytest.fixture
def experiment(tmp_path) -> Path:
    """The paper's experiment, over after 1.5 s."""
    text = (config_folder() / 'experiments' / 'kebria_fig11.yaml').read_text()
    file = tmp_path / 'short.yaml'
    file.write_text(text.replace('duration: 20.0\nramp: 2.0\n', SHORT))
    assert SHORT in file.read_text()
    return file


def hashes(text):
    """Return the lines that scripts look for."""
    return [line for line in text.splitlines()
            if re.fullmatch('sha256 of [a-z_/]+: [0-9a-f]{64}', line)]


def children_of(pid):
    """Return the pids of all descendants."""
    found, parents = [], {}
    for status in Path('/proc').glob('[0-9]*/stat'):
        try:
            fields = status.read_text().rpartition(')')[2].split()
        except OSError:
            continue
        parents[int(status.parent.name)] = int(fields[1])
    new = {pid}
    while new:
        new = {child for child, parent in parents.items() if parent in new}
        found += new
    return found


def test_demo_judges_itself_and_repeats_to_the_bit_beside_a_busy_loop(ur5, experiment, tmp_path):
    first = ur5('demo', '--experiment', experiment)
    assert first.code == 0, first
    run, = (tmp_path / 'bags').iterdir()
    assert {path.name for path in run.iterdir()} == {
        'sim', 'control', 'report.html', 'result.json', 'sim.log', 'control.log'}
    assert json.loads((run / 'result.json').read_text())['verdict'] == 'pass'
    assert (run / 'report.html').read_text().startswith('<!DOCTYPE html>')
    assert f'report: bags/{run.name}/report.html' in first.out
    assert re.search(r'^[\d.]+ s in [\d.]+ s of wall clock', first.out, re.MULTILINE)
    assert f'{run.name}: pass' in first.out and '\x1b[' not in first.out + first.err
    busy = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
    try:
        second = ur5('demo', '--experiment', experiment, '--run', 'again')
    finally:
        busy.kill()
        busy.wait()
    assert second.code == 0, second
    assert len(hashes(first.out)) == 2 and hashes(first.out) == hashes(second.out)
    same = ur5('compare', f'bags/{run.name}', 'again')
    assert same.code == 0 and 'to the last bit' in same.out


def test_a_wrong_mass_in_the_law_fails_and_names_the_joint(ur5, experiment, tmp_path):
    text = arm_text('ur5')
    assert text.count('mass: 8.393') == 1
    (tmp_path / 'wrong.yaml').write_text(text.replace('mass: 8.393', 'mass: 8.3'))
    demo = ur5('demo', '--experiment', experiment, '--control-arm', 'wrong.yaml', '--run', 'run')
    assert demo.code == 1, demo
    judged = ur5('validate', 'run', '--json', 'result.json')
    assert judged.code == 1
    checks = {check['name']: check
              for check in json.loads((tmp_path / 'result.json').read_text())['checks']}
    assert checks['residual, simulator arm']['verdict'] == 'pass'
    assert checks['residual, controller arm']['verdict'] == 'fail'
    assert 'shoulder_lift_joint' in checks['residual, controller arm']['sentence']
    assert 'shoulder_lift_joint' in judged.out


@pytest.mark.parametrize(('number', 'code'), [(signal.SIGINT, 130), (signal.SIGTERM, 130)])
def test_an_interrupted_demo_leaves_no_process_and_a_readable_run(ur5, tmp_path, number, code):
    demo = subprocess.Popen(
        [sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'demo', '--run', 'run'],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=dict(os.environ))
    bag = tmp_path / 'run' / 'control' / 'control_0.mcap'
    try:
        end = time.monotonic() + 60.0
        while time.monotonic() < end and not (bag.exists() and bag.stat().st_size > 400_000):
            time.sleep(0.02)
        children = children_of(demo.pid)
        assert len(children) >= 2
        demo.send_signal(number)
        out, err = demo.communicate(timeout=120)
    finally:
        demo.kill()
        demo.wait()
    assert demo.returncode == code, (out, err)
    assert err == 'ur5: interrupted\n'
    assert not [pid for pid in children if Path(f'/proc/{pid}').exists()]
    judged = ur5('validate', 'run')
    assert judged.code in (0, 1) and 'run:' in judged.out


def test_an_existing_run_folder_is_left_as_it_is(ur5, experiment, tmp_path):
    (tmp_path / 'run').mkdir()
    (tmp_path / 'run' / 'mine').write_text('kept')
    refused = ur5('demo', '--experiment', experiment, '--run', 'run')
    assert refused.code == 2 and 'run exists' in refused.err
    assert [path.name for path in (tmp_path / 'run').iterdir()] == ['mine']
