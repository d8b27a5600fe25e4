"""The benchmarks work: each cheap one runs to its table, and the page shows what is kept."""

import importlib
import importlib.util
import json
import os
import runpy
import subprocess
import sys
import time
from pathlib import Path

import pytest
from ros_processes import processes_with, wait_until
from thorough import times

from ur5_ros.launcher.node_processes import private_environment

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / 'benchmarks'
WITHOUT_ROS = ('bag', 'contact', 'control', 'friction', 'laws', 'loop_without_ros',
               'real_recordings', 'sweep')
WITH_ROS = ('recording', 'start', 'lockstep', 'profile')


def run(script, *arguments):
    done = subprocess.run([sys.executable, str(FOLDER / script), *arguments], text=True,
                          capture_output=True, timeout=300, stdin=subprocess.DEVNULL,
                          env={**os.environ, 'UR5_ROS_CORE': ''})
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize('name', [*WITHOUT_ROS, *WITH_ROS])
def test_a_quick_benchmark_prints_its_table_and_keeps_nothing(name):
    kept = {path: path.read_bytes() for path in FOLDER.glob('results/*.json')}
    out = run(f'bench_{name}.py', '--quick')
    assert '(bar ' in out
    assert {path: path.read_bytes() for path in FOLDER.glob('results/*.json')} == kept


def test_what_is_not_compared_cannot_be_compared():
    assert importlib.util.find_spec('pinocchio')
    assert importlib.util.find_spec('pinocchio.casadi') is None, 'a row of bench_model.py now'


def test_a_program_that_is_not_installed_is_left_out_with_one_line(monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(FOLDER))
    module = importlib.import_module('rivals')
    assert module.optional('no_such_program.part') is None
    assert capsys.readouterr().out.startswith('left out: no_such_program.part')


def test_every_benchmark_has_a_quick_mode(monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(FOLDER))
    for script in FOLDER.glob('bench_*.py'):
        monkeypatch.setattr('sys.argv', [str(script), '--help'])
        with pytest.raises(SystemExit) as end:
            runpy.run_path(str(script), run_name='__main__')
        assert end.value.code == 0 and '--quick' in capsys.readouterr().out, script.name


@pytest.mark.thorough
@pytest.mark.parametrize('script', times(
    ['bench_laws', 'bench_lockstep', 'bench_recording', 'ping_pong', 'sweep_proof'],
    ['bench_laws', 'bench_lockstep', 'bench_paced', 'bench_profile', 'bench_recording',
     'bench_scaling', 'bench_start', 'bench_sweep', 'ping_pong', 'soak', 'sweep_proof']))
def test_a_benchmark_that_is_killed_leaves_no_process_behind(script, tmp_path):
    mark = f'MARK={tmp_path}'
    command = [sys.executable, str(FOLDER / f'{script}.py'),
               *(['--quick'] if script.startswith('bench') else [])]
    benchmark = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=tmp_path,
        env=private_environment() | {'TMPDIR': str(tmp_path), 'MARK': str(tmp_path)})
    try:
        wait_until(lambda: len(processes_with(mark)) > 1, 'a process that it starts')
        time.sleep(1.0)  # the processes of these, too
    finally:
        benchmark.kill()
        benchmark.wait()
    wait_until(lambda: not processes_with(mark), 'the end of all others', 15.0)


def test_a_checkout_gives_its_own_figures_for_a_comparison_of_versions():
    figures = json.loads(run('version_probe.py', 'loops', '0.02'))
    assert {'step, with friction', 'update, caches emptied before each call'} <= set(figures)
    assert all(0.0 < seconds < 1.0 for seconds in figures.values())


def test_a_comparison_with_a_folder_that_is_no_checkout_is_refused_in_one_line(tmp_path):
    done = subprocess.run([sys.executable, str(FOLDER / 'versions.py'), '--old', str(tmp_path)],
                          text=True, capture_output=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.strip() == f'{tmp_path}: no .venv/bin/python; run make setup-all there'


def test_the_page_names_every_figure_and_every_miss(tmp_path):
    row = {'measured': 'ours', 'reference': 'theirs', 'ratio': 0.5, 'bar': 1.0, 'at_least': True,
           'detail': 'why', 'met': False}
    (tmp_path / 'one.json').write_text(json.dumps({
        'title': 'One thing', 'date': '2026-01-01', 'rows': [row],
        'machine': {'python': '3.11', 'system': 'Linux', 'processor': 'P', 'cores': '2'},
        'parts': {'step': 1e-5}}))
    run('table.py', '--results', str(tmp_path), '--page', str(tmp_path / 'page.md'))
    text = (tmp_path / 'page.md').read_text()
    assert '| ours | theirs | 0.5 | at least 1 | **missed** | why |' in text
    assert '- One thing: ours, 0.5 of theirs' in text
    assert '| step | 10.0 |' in text


def test_the_page_shown_is_the_one_of_the_results_kept(tmp_path):
    run('table.py', '--page', str(tmp_path / 'page.md'))
    assert (tmp_path / 'page.md').read_text() == (ROOT / 'docs' / 'performance.md').read_text()
