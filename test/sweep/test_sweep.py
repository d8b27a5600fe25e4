"""Sweeps lose no run, double none, and come out the same whoever did the work."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import polars
import pytest
from command import PROGRAM, Command

from ur5_ros.errors import InputError
from ur5_ros.sweep.engine import batch_size, lost_row, run_batch, run_sweep
from ur5_ros.sweep.report import write_report
from ur5_ros.sweep.run import check_success, config_of, row_of
from ur5_ros.sweep.spec import expand, load_sweep, number_of_runs, parse_sweep
from ur5_ros.sweep.summary import heat_maps, overall, rate_of, rates_by, worst_runs
from ur5_ros.sweep.table import SweepFolder, open_sweep

SPEC = """
name: trial
duration: 0.15
judge: metrics
success: {max_error: 0.2}
vary:
  sim.payload.mass: [0.0, 0.5]
  control.kp: {from: 5.0, to: 50.0, count: 3}
"""
LONGER = SPEC.replace('count: 3', 'count: 60').replace('0.15', '0.4')


def spec_of(text=SPEC):
    return parse_sweep(text, 'trial.yaml')


@pytest.fixture(scope='module')
def alone(tmp_path_factory):
    """The table of the trial, made in this process run by run."""
    folder = SweepFolder(tmp_path_factory.mktemp('alone'), spec_of())
    for run in expand(folder.spec):
        folder.add([row_of(folder.spec, run, None)])
    return folder.table()


class Cluster:
    """A Dask scheduler and its workers as processes of this machine."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self.address = f'tcp://127.0.0.1:{probe.getsockname()[1]}'
        self.processes: list[subprocess.Popen] = []

    def start(self, *arguments: str) -> subprocess.Popen:
        log = open(self.folder / f'dask_{len(self.processes)}.log', 'wb')  # noqa: SIM115
        with log:
            process = subprocess.Popen(
                [sys.executable, '-m', 'distributed.cli.' + arguments[0], *arguments[1:]],
                stdout=log, stderr=log, cwd=self.folder, start_new_session=True,
                env=os.environ | {'DASK_TEMPORARY_DIRECTORY': str(self.folder)})
        self.processes.append(process)
        return process

    def scheduler(self) -> subprocess.Popen:
        port = self.address.rpartition(':')[2]
        process = self.start('dask_scheduler', '--host', '127.0.0.1', '--port', port,
                             '--no-dashboard')
        end = time.monotonic() + 120.0
        while process.poll() is None and time.monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(('127.0.0.1', int(port))) == 0:
                    return process
            time.sleep(0.05)
        raise AssertionError('the scheduler did not start')

    def worker(self, threads: int = 1) -> subprocess.Popen:
        return self.start('dask_worker', self.address, '--nthreads', str(threads), '--no-nanny',
                          '--no-dashboard', '--death-timeout', '60')

    def close(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run_and_interrupt(folder, cluster, interrupt):
    """Run a sweep on a cluster, and do something once when the first runs are done."""
    interrupted = []

    def progress(done):
        if done > 0 and not interrupted:
            interrupted.append(done)
            interrupt()

    run_sweep(folder.spec, folder, cluster.address, progress=progress)
    assert interrupted and interrupted[0] < number_of_runs(folder.spec)


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.close()


def test_a_cluster_of_processes_gives_the_table_of_one_process(cluster, alone, tmp_path):
    cluster.scheduler()
    cluster.worker()
    cluster.worker()
    folder = SweepFolder(tmp_path / 'sweep', spec_of())
    reported = []
    run_sweep(folder.spec, folder, cluster.address, progress=reported.append)
    assert reported[0] == 0 and reported[-1] == 6 and reported == sorted(reported)
    assert folder.table().equals(alone)
    path = folder.write_table()
    assert polars.read_parquet(path).equals(alone)


def test_threads_of_one_worker_do_not_disturb_each_other(cluster, tmp_path):
    cluster.scheduler()
    cluster.worker(threads=4)
    text = SPEC.replace('count: 3', 'count: 30').replace('duration: 0.15', 'duration: 1.0')
    folder = SweepFolder(tmp_path / 'sweep', spec_of(text))
    run_sweep(folder.spec, folder, cluster.address)
    alone = [row_of(folder.spec, run, None) for run in expand(folder.spec)]
    assert [row['states'] for row in alone] == folder.table()['states'].to_list()


def test_a_killed_worker_loses_no_run_and_doubles_none(cluster, tmp_path):
    cluster.scheduler()
    victim, _ = cluster.worker(), cluster.worker()
    folder = SweepFolder(tmp_path / 'sweep', spec_of(LONGER))
    run_and_interrupt(folder, cluster, lambda: os.killpg(victim.pid, signal.SIGKILL))
    rows = [index for part in (tmp_path / 'sweep' / 'parts').glob('*.parquet')
            for index in polars.read_parquet(part)['index']]
    assert sorted(rows) == list(range(120))
    assert set(folder.table()['status']) <= {'pass', 'fail'}


def test_a_scheduler_that_goes_and_comes_back_costs_nothing_that_was_done(cluster, tmp_path):
    scheduler = cluster.scheduler()
    cluster.worker()
    folder = SweepFolder(tmp_path / 'sweep', spec_of(LONGER))

    def restart():
        os.killpg(scheduler.pid, signal.SIGKILL)
        scheduler.wait()
        cluster.scheduler()
        cluster.worker()

    run_and_interrupt(folder, cluster, restart)
    assert folder.table()['index'].to_list() == list(range(120))


def test_an_answer_that_is_not_a_schedulers_is_reported_in_one_line(tmp_path):
    folder = SweepFolder(tmp_path / 'sweep', spec_of())
    with socket.create_server(('127.0.0.1', 0)) as server:
        def greet():
            for _ in range(20):
                connection, _ = server.accept()
                connection.sendall(b'HTTP/1.1 400 Bad Request\r\n\r\n' * 10)
                kept.append(connection)
        kept = []
        threading.Thread(target=greet, daemon=True).start()
        address = f'tcp://127.0.0.1:{server.getsockname()[1]}'
        with pytest.raises(InputError, match='no Dask scheduler answers') as refusal:
            run_sweep(folder.spec, folder, address)
        assert '\n' not in str(refusal.value)
        for connection in kept:
            connection.close()


def test_success_is_asked_of_numbers_that_there_are():
    check_success(spec_of())
    check_success(spec_of('name: a\nsuccess: {"joint tracking": 0.1, rms_error: 0.2}\n'))
    for judge in ('metrics', 'checks'):
        with pytest.raises(InputError, match="'maxerror'; there are: max_error"):
            check_success(spec_of(f'name: a\njudge: {judge}\nsuccess: {{maxerror: 0.1}}\n'))


def test_an_address_without_a_scheduler_is_reported_within_ten_seconds(cluster, tmp_path):
    folder = SweepFolder(tmp_path / 'sweep', spec_of())
    with pytest.raises(InputError, match='no Dask scheduler answers at ' + cluster.address):
        run_sweep(folder.spec, folder, cluster.address)


def test_an_interrupted_sweep_goes_on_where_it_was(alone, tmp_path):
    folder = SweepFolder(tmp_path / 'sweep', spec_of())
    runs = list(expand(folder.spec))
    folder.add([row_of(folder.spec, run, None) for run in runs[1:3]])
    (tmp_path / 'sweep' / 'parts' / '0000004-1.unfinished').write_bytes(b'cut')
    again = SweepFolder(tmp_path / 'sweep', spec_of())
    assert again.done() == {1, 2}
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / 'sweep').rglob('*.parquet')}
    run_sweep(again.spec, again, workers=1)
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())
    assert again.table().equals(alone)
    assert open_sweep(tmp_path / 'sweep').table().equals(alone)


def test_two_sweeps_do_not_work_in_one_folder(tmp_path):
    folder = SweepFolder(tmp_path / 'sweep', spec_of())
    with folder.lock(), pytest.raises(InputError, match='another ur5 sweep works'):
        run_sweep(folder.spec, SweepFolder(tmp_path / 'sweep', spec_of()), workers=1)
    with folder.lock():
        assert folder.done() == set()


def test_rows_of_other_code_are_not_mixed_with_those_of_this(alone, tmp_path):
    folder = SweepFolder(tmp_path, spec_of())
    folder.add([row_of(folder.spec, next(iter(expand(folder.spec))), None)])
    software = json.loads((tmp_path / 'software.json').read_text())
    assert {'sources', 'numpy', 'processor'} <= software.keys()
    (tmp_path / 'software.json').write_text(json.dumps(software | {'sources': 'before'}))
    with pytest.raises(InputError, match='computed by other code') as refused:
        run_sweep(folder.spec, folder, workers=1)
    assert '--out' in str(refused.value) and '\n' not in str(refused.value)
    (tmp_path / 'software.json').write_text(json.dumps(software))
    run_sweep(folder.spec, folder, workers=1)
    assert folder.table().equals(alone)


def test_a_worker_with_other_code_ends_the_sweep_and_not_its_rows():
    spec = spec_of()
    with pytest.raises(InputError, match='a worker has other code') as refused:
        run_batch(spec, None, 'other', list(expand(spec)))
    with pytest.raises(InputError, match='start it again'):
        lost_row(next(iter(expand(spec))), refused.value)


def test_a_folder_of_another_sweep_is_not_changed(tmp_path):
    SweepFolder(tmp_path / 'sweep', spec_of())
    with pytest.raises(InputError, match='another sweep'):
        SweepFolder(tmp_path / 'sweep', spec_of(SPEC.replace('0.15', '0.2')))
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'thesis.txt').write_text('kept')
    with pytest.raises(InputError, match='not empty'):
        SweepFolder(tmp_path / 'mine', spec_of())


@pytest.mark.parametrize(('text', 'named'), [
    ('vary:\n  control.gain: [1.0]\n', 'gain'),
    ('vary:\n  speed: [1.0]\n', "unknown key 'speed'"),
    ('vary:\n  control_rate: [300]\nfixed: {physics_rate: 1000}\n', 'use 250 or 500'),
    ('vary:\n  control.kp: [-1.0]\n', 'kp'),
    ('vary:\n  arm: [ur5, ur6]\n', 'ur6'),
    ('vary:\n  experiment: [fig12]\n', 'fig12'),
    ('vary:\n  arm: [3]\n', 'arm'),
    ('vary:\n  duration: [0.0]\n', 'duration'),
    ('vary:\n  initial_error: {uniform: [-0.1, 0.1], size: 5}\n', 'initial_error six'),
    ('vary:\n  control.kd: [10.0, 2500.0]\n', 'control.kd unstable'),
    ('vary:\n  initial_error: [9.0]\n', 'initial_error stop'),
    ('vary:\n  sim.gui: [true]\n', 'sim.gui'),
    ('fixed: {control.experiment: fig12}\nvary:\n  arm: [ur5]\n', 'control.experiment'),
])
def test_what_cannot_run_is_refused_by_name_before_anything_starts(text, named):
    spec = spec_of('name: trial\n' + text)
    with pytest.raises(InputError, match='.*'.join(named.split())):
        for run in expand(spec):
            config_of(spec, run)


def test_a_run_that_diverges_is_a_row(tmp_path):
    spec = spec_of(
        'name: wild\nduration: 1.0\nfixed: {control.mode: pd, control.kp: [1.0], '
        'control.kd: [0.01]}\nvary:\n  arm: [ur5]\n')
    row = row_of(spec, next(expand(spec)), None)
    assert row['status'] == 'diverged' and row['success'] is False
    assert 'from its reference' in row['why']


def test_failures_leave_their_bags_and_the_others_do_not(tmp_path):
    spec = spec_of(SPEC.replace('judge: metrics', 'judge: metrics\nkeep: failures').replace(
        '0.2}', '0.1502}'))
    rows = [row_of(spec, run, tmp_path) for run in expand(spec)]
    failed = {f'{row["index"]:06d}' for row in rows if not row['success']}
    assert failed and len(failed) < len(rows)
    assert {path.name for path in tmp_path.iterdir()} == failed


def test_a_run_by_the_two_nodes_has_the_row_of_the_loop(tmp_path):
    text = SPEC.replace('[0.0, 0.5]', '[0.1]').replace('count: 3', 'count: 1').replace(
        'from: 5.0, to: 50.0', 'from: 5.0, to: 5.0')
    rows = []
    for engine in ('loop', 'nodes'):
        spec = spec_of(text + f'engine: {engine}\nkeep: failures\n')
        rows += [row_of(spec, run, tmp_path / engine) for run in expand(spec)]
    assert rows[0] == rows[1] and rows[0]['success']
    assert not list(tmp_path.rglob('*.mcap'))


def test_workers_run_the_two_nodes_beside_each_other(cluster, tmp_path):
    cluster.scheduler()
    cluster.worker(threads=2)
    tables = []
    for engine in ('loop', 'nodes'):
        folder = SweepFolder(tmp_path / engine, spec_of(
            SPEC.replace('count: 3', 'count: 2') + f'engine: {engine}\n'))
        run_sweep(folder.spec, folder, cluster.address)
        tables.append(folder.table())
    assert tables[0].equals(tables[1]) and tables[0].height == 4
    assert set(tables[0]['status']) <= {'pass', 'fail'}


def test_every_check_of_the_validator_has_its_columns():
    spec = spec_of('name: judged\nduration: 0.5\nvary:\n  arm: [ur5]\n')
    row = row_of(spec, next(expand(spec)), None)
    assert row['residual, controller arm: verdict'] == 'pass'
    assert row['residual, controller arm: value'] < 1e-9
    assert len(row['states']) == 64


def test_shipped_sweeps_can_run_and_say_what_they_ask(repo):
    names = [path.stem for path in (repo / 'config' / 'sweeps').glob('*.yaml')]
    assert len(names) == 3
    for name in names:
        spec = load_sweep(name)
        assert spec.name == name and spec.question.endswith('?')
        runs = list(expand(spec))
        assert len(runs) == number_of_runs(spec) <= 200
        for run in runs:
            config_of(spec, run)


def test_tasks_are_neither_tiny_nor_long():
    assert batch_size(spec_of()) == 200
    assert batch_size(spec_of('name: long\nduration: 600.0\n')) == 1


def test_rates_of_lists_stand_in_the_order_of_their_numbers():
    table = polars.DataFrame({'control.kp': ['[100.0]', '[10.0]', '[50.0]', None],
                              'success': [True, False, True, True]})
    assert list(rates_by(table, 'control.kp')) == ['[10.0]', '[50.0]', '[100.0]', None]


def test_rates_have_wilsons_interval():
    # Brown, Cai, DasGupta 2001, Statistical Science 16, p. 108: x = 0, n = 10 gives [0, 0.2775]
    none = rate_of(10, 0)
    assert none.low == 0.0 and none.high == pytest.approx(0.2775, abs=5e-5)
    half = rate_of(100, 50)
    assert half.low == pytest.approx(1.0 - half.high)
    assert rate_of(10_000, 5_000).high - 0.5 == pytest.approx(1.96 * 0.5 / 100, rel=1e-3)


def test_the_summary_counts_what_the_table_holds(alone):
    spec = spec_of()
    assert overall(alone).runs == 6
    rates = rates_by(alone, 'sim.payload.mass')
    assert list(rates) == [0.0, 0.5]
    assert sum(rate.successes for rate in rates.values()) == alone['success'].sum()
    maps = heat_maps(alone, spec, ['max_error'])
    assert [heat.what for heat in maps] == ['success rate', 'max_error']
    assert len(maps[0].z) == len(maps[0].y_values) and len(maps[0].z[0]) == len(maps[0].x_values)
    worst = worst_runs(alone, 2)
    assert worst[0]['max_error'] == alone['max_error'].max()


def test_the_command_runs_resumes_reports_and_repeats_one_run(tmp_path):
    file = tmp_path / 'trial.yaml'
    file.write_text(SPEC)
    ur5 = partial(Command(tmp_path), 'sweep')
    first = ur5(file, '--workers', 2)
    assert first.code == 0, first
    table = (tmp_path / 'sweeps' / 'trial' / 'table.parquet').read_bytes()
    assert '--only' in first.out or '6 of 6' in first.out
    assert first.err == ''
    report = (tmp_path / 'sweeps' / 'trial' / 'report.html').read_text()
    assert 'heatmap' in report and 'Runs, the worst first' in report
    began = time.monotonic()
    assert ur5(file).code == 0
    assert (tmp_path / 'sweeps' / 'trial' / 'table.parquet').read_bytes() == table
    assert time.monotonic() - began < 60.0
    assert ur5('report', 'sweeps/trial').code == 0
    one = ur5('sweeps/trial/sweep.json', '--only', 4, '-o', 'one')
    assert (tmp_path / 'one' / '000004' / 'sim' / 'metadata.yaml').exists()
    row = polars.read_parquet(tmp_path / 'sweeps' / 'trial' / 'table.parquet').row(4, named=True)
    assert f'states: {row["states"]}' in one.out
    assert one.code == (0 if row['success'] else 1)
    assert ur5(file, '--only', 6).code == 2


def test_ctrl_c_keeps_what_is_done(tmp_path):
    file = tmp_path / 'trial.yaml'
    file.write_text(SPEC.replace('count: 3', 'count: 400').replace('0.15', '1.0'))
    sweep = subprocess.Popen(
        [*PROGRAM, 'sweep', str(file), '--workers', '1'], cwd=tmp_path, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, start_new_session=True)
    parts = tmp_path / 'sweeps' / 'trial' / 'parts'
    try:
        end = time.monotonic() + 120.0
        while not list(parts.glob('*.parquet')) and time.monotonic() < end:
            time.sleep(0.05)
        os.killpg(sweep.pid, signal.SIGINT)
        out, err = sweep.communicate(timeout=120)
    finally:
        if sweep.poll() is None:
            os.killpg(sweep.pid, signal.SIGKILL)
        sweep.wait()
    assert sweep.returncode == 130, (out, err)
    assert 'Traceback' not in err
    assert 'of 800 runs done; the same command continues' in out
    done = SweepFolder(tmp_path / 'sweeps' / 'trial', spec_of(file.read_text())).done()
    assert 0 < len(done) < 800
    assert json.loads((parts.parent / 'sweep.json').read_text())['name'] == 'trial'


def test_the_page_of_a_random_sweep_has_scatters_intervals_units_and_short_numbers(tmp_path):
    spec = spec_of('name: drawn\nduration: 0.3\njudge: metrics\nsamples: 6\n'
                   'success: {final_error: 0.05}\nvary:\n  arm: [ur5]\n'
                   '  initial_error: {uniform: [-0.1, 0.1], size: 6}\n'
                   '  sim.payload.mass: {uniform: [0.0, 2.0]}\n')
    folder = SweepFolder(tmp_path / 'drawn', spec)
    folder.add([row_of(spec, run, None) for run in expand(spec)])
    write_report(folder, tmp_path / 'page.html')
    page = (tmp_path / 'page.html').read_text(encoding='utf-8')
    table = folder.table()
    worst = f'{1e3 * table["final_error"].max():.4g}'  # mm and mrad on screens
    for words in ('All random values', 'sim.payload.mass [kg]', '95 % interval',
                  'final_error [mrad]', f'<td>{worst}</td>', 'final_error at most 50 mrad'):
        assert words in page
    assert f'final_error is {worst} mrad, more than 50 mrad' in table['why'].to_list()
    body = page.partition('<main>')[2].partition('</main>')[0]
    assert not re.search(r'\d\.\d{8,}', body), 'no number of more than eight decimals'
    assert len(page) < 3_000_000


def test_the_page_of_a_grid_has_no_interval_as_nothing_is_random(tmp_path):
    spec = spec_of('name: grid\nduration: 0.3\njudge: metrics\nsuccess: {final_error: 1.0}\n'
                   'vary:\n  control.kp: [10.0, 20.0]\n')
    folder = SweepFolder(tmp_path / 'grid', spec)
    folder.add([row_of(spec, run, None) for run in expand(spec)])
    write_report(folder, tmp_path / 'page.html')
    assert '95 % interval' not in (tmp_path / 'page.html').read_text(encoding='utf-8')
