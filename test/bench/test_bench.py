"""The bench treats all laws alike, finds what they survive, and says what is wrong with a file."""

import os
import re
import subprocess
import time

import numpy as np
import polars
import pytest
from command import PROGRAM, Command
from law_files import LAW
from numpy.testing import assert_allclose
from ros_processes import processes_with, wait_until

from ur5_ros.bench import limited_job
from ur5_ros.bench.entries import LAWS, Candidate, Tuned, entry_of, load_bench, load_entries
from ur5_ros.bench.jobs import do_jobs
from ur5_ros.bench.perturbations import ACCURATE, PERTURBATIONS, SURVIVES, conditions_of
from ur5_ros.bench.probe import probed_entry
from ur5_ros.bench.report import write_report
from ur5_ros.bench.runs import (
    LARGEST_TRIED,
    Job,
    border_conditions,
    borders_of,
    jobs_of,
    row_of,
    run_of,
)
from ur5_ros.bench.scores import SCORES, scores_of
from ur5_ros.bench.table import border_text, summary
from ur5_ros.bench.tuning import candidates, pareto_front, write_bench
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.run_config import run_config

#: A law that counts its calls and lets the arm hang.
COUNTING = """
import time
from ur5_ros import dynamics_terms

class Law:
    def __init__(self, arm, gains, parameters):
        self.arm, self.calls = arm, 0

    def __call__(self, state, reference, dt):
        self.calls += 1
        {body}
        return dynamics_terms(state.q + self.arm.angle_offset, state.qd, self.arm)[2]
"""
ENDLESS = 'while self.calls > 300: time.sleep(9)'
RIGHT = """M, C, g = dynamics_terms(state.q + self.arm.angle_offset, state.qd, self.arm)
        a = (reference.qdd - self.gains.kd @ (state.qd - reference.qd)
             - self.gains.kp @ (state.q - reference.q))
        return M @ a + C @ state.qd + g"""


def entry(name):
    return next(each for each in load_entries() if each.name == name)


def test_every_law_has_the_best_gains_of_the_same_search():
    found = load_bench()
    assert set(found.laws) == set(LAWS)
    for law in LAWS:
        tried = [row for row in found.tried if row.law == law]
        assert list(map(vars_of, tried)) == list(map(vars_of, candidates()))
        best = min(tried, key=lambda row: row.cost)
        assert vars_of(found.laws[law]) == vars_of(best)


def vars_of(gains):
    return gains.frequency, gains.damping, gains.own


def test_two_numbers_mean_the_same_spring_in_laws_with_and_without_m():
    gains = Tuned(20.0, 0.7, 1.0)
    weighed, plain = (entry_of(name, gains).control for name in ('computed_torque', 'gravity_pd'))
    assert_allclose(weighed['kp'], 400.0)
    assert_allclose(np.array(plain['kd']) / plain['kp'], 2.0 * 0.7 / 20.0)


@pytest.mark.parametrize('name', ['nothing', *PERTURBATIONS])
def test_a_perturbation_is_the_same_for_all_laws_and_differs_between_seeds(name):
    (_, first), (_, again), (_, other) = (conditions_of(name, seed) for seed in (1, 1, 2))
    assert_allclose(first, again, atol=0.0)
    assert np.abs(first - other).max() > 1e-4
    assert conditions_of(name, 1)[0].sim == conditions_of(name, 1)[0].sim


def test_an_unknown_perturbation_is_refused():
    with pytest.raises(InputError, match="unknown perturbation 'wind'; give one of: nothing"):
        conditions_of('wind', 0)


def test_the_scores_are_what_the_states_say():
    run = run_closed_loop(run_config('multi_sine', 'ur5_real', duration=1.0))
    scores = scores_of(run)
    error = (run.q - run.reference.q)[500:]
    assert_allclose(scores['max_error'], np.abs(error).max())
    assert_allclose(scores['rms_error'], np.sqrt(np.mean(error**2)))
    assert_allclose(scores['energy'], np.sum(np.abs(run.effort * run.qd)) * 1e-3)
    assert set(scores) == set(SCORES)


@pytest.mark.parametrize('law', LAWS)
def test_every_law_survives_the_ordinary_run_with_its_tuned_gains(law):
    row = row_of(Job(entry(law), 'nothing', 0))
    assert row['survived'], row['why']


@pytest.mark.parametrize(('law', 'what', 'step'), [
    ('pd', 'payload', 0.125), ('sliding_mode', 'delay', 1.0)])
def test_the_largest_payload_and_delay_are_borders_between_surviving_and_not(law, what, step):
    found = borders_of(entry(law), what)

    def worst(value):
        error = run_of(entry(law), border_conditions(what, value), np.zeros(6))['max_error']
        return np.inf if error is None else error
    for border, within in ((found['largest'], SURVIVES), (found['accurate'], ACCURATE)):
        assert 0.0 < border < LARGEST_TRIED[what]  # no law survives all that is tried
        assert worst(border) <= within < worst(border + step)
    assert found['accurate'] < found['largest']


def test_what_survives_all_that_is_tried_is_said_to_survive_more(monkeypatch):
    monkeypatch.setitem(LARGEST_TRIED, 'delay', 4.0)
    found = borders_of(entry('computed_torque'), 'delay')
    assert found == {'largest': np.inf, 'accurate': np.inf}
    row = {'delay': found['largest'], 'accurate_delay': found['accurate']}
    assert border_text(row, 'delay') == '> 4 (> 4)'
    assert border_text({'payload': 21.625, 'accurate_payload': 11.375}, 'payload') == '21.6 (11.4)'
    assert border_text({}, 'payload') == '-'


def law_file(tmp_path, text):
    file = tmp_path / 'my_law.py'
    file.write_text(text, encoding='utf-8')
    return file


def test_a_law_of_a_file_that_is_computed_torque_scores_like_computed_torque(tmp_path):
    written = probed_entry(law_file(tmp_path, LAW.format(body=RIGHT)))
    assert written.name == 'my_law.py'
    mine, own = (row_of(Job(each, 'payload', 3)) for each in (written, entry('computed_torque')))
    for score in SCORES:
        assert_allclose(mine[score], own[score], rtol=1e-6)


def test_a_law_that_does_not_weigh_by_m_gets_the_gains_of_one_that_does_not(tmp_path):
    text = LAW.format(body=RIGHT).replace('class Law:', 'class Law:\n    weighed = False')
    given = probed_entry(law_file(tmp_path, text)).control
    assert given['kp'] == entry('gravity_pd').control['kp']


@pytest.mark.parametrize(('body', 'words'), [
    ('return [float("nan")] * 6', 'torque of joint 1 is nan'),
    ('return [0.0] * 7', r'the torque has the shape \(7,\)'),
    ('return None', r'returns nothing \(None\)'),
    ('import time; time.sleep(0.05); return [0.0] * 6', 'too late: it takes .* ms a period'),
    ('self.kept = bytearray(2**30); return [0.0] * 6', 'MemoryError|512 MB'),
    ('import os; os.abort()', r'ended by signal 6'),
    ('import os; os._exit(0)', r'ended with code 0 before there was a result'),
    ('raise SystemExit(0)', r'SystemExit: 0 \(line 9\)'),
])
def test_a_law_that_cannot_run_is_refused_in_one_line(tmp_path, body, words):
    with pytest.raises(InputError, match=words) as refusal:
        probed_entry(law_file(tmp_path, LAW.format(body=body)))
    assert '\n' not in str(refusal.value) and 'my_law.py' in str(refusal.value)


@pytest.mark.parametrize(('text', 'words'), [
    ('x = 1\n', 'defines no class Law; give it one with __init__'),
    ('while True:\n    pass\n', 'no result after 5 s; an endless loop'),
    ('import os\nos._exit(0)\n', 'ended with code 0 before'),
    ('import no_such_module\n', r"No module named 'no_such_module' \(line 1\)"),
])
def test_a_file_whose_import_is_wrong_is_refused_in_one_line_by_its_own_process(
        tmp_path, text, words):
    with pytest.raises(InputError, match=words) as refusal:
        probed_entry(law_file(tmp_path, text), seconds=5.0 if 'while' in text else 60.0)
    assert '\n' not in str(refusal.value) and 'my_law.py' in str(refusal.value)


@pytest.mark.parametrize(('body', 'words'), [
    (ENDLESS, 'too late: no result after 5 s'),
    ('if self.calls > 300: import os; os.abort()', r'ended by signal 6 \(SIGABRT\)'),
    ('if self.calls > 300: self.kept = bytearray(2**30)', 'MemoryError|512 MB'),
])
def test_a_law_that_breaks_in_the_middle_of_a_run_is_a_row_and_harms_no_other(
        tmp_path, body, words):
    text = COUNTING.format(body=body)
    mine = probed_entry(law_file(tmp_path, text))._replace(timeout=5.0)
    rows = do_jobs([(0, Job(mine, 'payload', 0)), (1, Job(entry('pd'), 'payload', 0))])
    assert not rows[0]['survived'] and re.search(words, rows[0]['why'])
    assert rows[0]['rms_error'] is None and rows[0]['law'] == 'my_law.py'
    assert rows[1]['survived'] and rows[1]['why'] == ''


def test_a_law_that_never_ends_survives_no_payload_and_no_delay(tmp_path, monkeypatch):
    monkeypatch.setattr(limited_job, 'RUNS_OF_A_SEARCH', 1)
    mine = probed_entry(law_file(tmp_path, COUNTING.format(body=ENDLESS)))
    row = do_jobs([(0, Job(mine._replace(timeout=4.0), 'delay', 0, True))])[0]
    assert not row['survived'] and row['why'].startswith('too late') and row['largest'] is None
    assert border_text({'delay': row['largest']}, 'delay') == '-'


def test_a_law_that_loses_the_arm_is_a_row_and_no_crash():
    row = do_jobs([(4, Job(entry('pd')._replace(control={'mode': 'pd', 'kp': [0.1], 'kd': [0.1]}),
                           'payload', 0))])[0]
    assert row['index'] == 4 and not row['survived']
    assert 'rad from its reference' in row['why'] or 'unstable' in row['why']


def test_the_front_holds_what_none_beats():
    def tried(error, rough, survived=4):
        return Candidate('pd', 1.0, 1.0, 1.0, 1.0, survived, error, rough)
    rows = [tried(1.0, 5.0), tried(2.0, 4.0), tried(3.0, 6.0), tried(0.1, 0.1, 3), tried(2.5, 1.0)]
    assert [(row.rms_error, row.roughness) for row in pareto_front(rows)] == [
        (1.0, 5.0), (2.0, 4.0), (2.5, 1.0)]


def test_what_the_search_writes_is_what_the_bench_reads_and_draws(tmp_path):
    tried = [Candidate(law, 12.5, 0.7, 1.0, 1e-5, 4, 1e-3, 50.0) for law in LAWS]
    tried.append(Candidate('pd', 1.0, 1.0, 1.0, 10.0, 0, None, None))
    found = load_bench()
    path = tmp_path / 'bench.yaml'
    write_bench(type(found)('by hand', found.laws, tried), path)
    assert load_bench(path).tried == tried
    assert load_entries(gains=path) == load_entries()
    rows = [{'index': i, 'law': law, 'perturbation': 'payload', 'seed': 0, 'kind': 'run',
             'rms_error': 1e-3, 'max_error': 2e-3, 'effort': 1.0, 'energy': 1.0, 'roughness': 1.0,
             'survived': True, 'why': ''} for i, law in enumerate(LAWS)]
    write_report(rows, tried, tmp_path / 'report.html')
    assert 'plot-pareto' in (tmp_path / 'report.html').read_text(encoding='utf-8')


def test_the_command_makes_table_and_report_in_a_minute_whatever_a_law_of_a_file_does(tmp_path):
    began = time.monotonic()
    endless = law_file(tmp_path, COUNTING.format(body=ENDLESS))
    done = Command(tmp_path)('bench', '--quick', '--law', endless, '--law-timeout', '8')
    assert done.code == 0, done.err
    assert 'my_law.py: too late: no result after 8 s; an endless loop? (2 of' in done.out
    table = polars.read_parquet(tmp_path / 'bench/table.parquet')
    mine = table.filter(polars.col('law') == 'my_law.py')
    assert mine['survived'].to_list() == [False, False]
    table = table.filter(polars.col('law') != 'my_law.py')
    assert len(table) == len(jobs_of(load_entries(), ('payload', 'delay'), 1, survival=False))
    assert len(table) == 2 * len(LAWS)
    assert table['survived'].all()
    assert summary(table.to_dicts())['law'].to_list() == list(LAWS)
    page = (tmp_path / 'bench/report.html').read_text(encoding='utf-8')
    assert 'plot-laws' in page
    assert '| cartesian_impedance |' in (tmp_path / 'bench/summary.md').read_text('utf-8')
    print(f'{time.monotonic() - began:.0f} s')


def test_a_bench_that_is_asked_to_end_leaves_no_process_and_no_file(tmp_path):
    scratch = tmp_path / 'scratch'
    scratch.mkdir()
    command = subprocess.Popen(
        [*PROGRAM, 'bench', '--out', str(tmp_path / 'bench')], stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, env={**os.environ, 'TMPDIR': str(scratch)})
    try:
        wait_until(lambda: list(scratch.glob('ur5-sweep-*/*/*')), 'the workers')
        command.terminate()
        assert command.wait(60.0) == 130
    finally:
        command.kill()
    assert 'interrupted' in command.stderr.read()
    assert list(scratch.iterdir()) == []
    wait_until(lambda: not processes_with(f'TMPDIR={scratch}'), 'the end of the workers')


@pytest.mark.parametrize(('arguments', 'words'), [
    (('--tune', '/proc/none.yaml'), 'give another file with --tune'),
    (('--out', '/proc/none'), 'give another folder with --out'),
    (('--gains', 'none.yaml'), 'none.yaml: no such file'),
    (('--workers', '0'), 'give at least 1'),
])
def test_what_cannot_be_read_or_written_is_bad_input_before_anything_runs(
        tmp_path, arguments, words):
    done = Command(tmp_path)('bench', *arguments)
    assert done.code == 2
    assert words in done.err and done.err.count('\n') == 1


@pytest.mark.parametrize(('name', 'text', 'words'), [
    ('none.py', None, 'no file'), ('', None, 'is a folder'),
    ('my_law.py', 'raise SystemExit(0)\n', 'SystemExit: 0 (line 1)')])
def test_a_law_file_that_is_none_is_bad_input(tmp_path, name, text, words):
    if text is not None:
        law_file(tmp_path, text)
    done = Command(tmp_path)('bench', '--law', tmp_path / name)
    assert done.code == 2
    assert words in done.err and done.err.count('\n') == 1
