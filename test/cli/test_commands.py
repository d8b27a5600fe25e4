"""Every command on a real run: what it prints, what it writes, how it exits."""

import gzip
import json
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.bag.reader import open_bag
from ur5_ros.config import load_arm
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.dynamics import inverse_dynamics


@pytest.fixture
def cut_run(short_run, tmp_path):
    """The run as a crash leaves it: files cut in the middle, metadata gone."""
    run = tmp_path / 'cut'
    shutil.copytree(short_run, run)
    for side in ('sim', 'control'):
        (run / side / 'metadata.yaml').unlink()
        file = run / side / f'{side}_0.mcap'
        file.write_bytes(file.read_bytes()[:int(file.stat().st_size * 0.7)])
    return run


def test_validate_takes_the_newest_run_and_writes_what_is_asked_for(ur5, short_run, tmp_path):
    shutil.copytree(short_run, tmp_path / 'bags' / 'mine')
    judged = ur5('validate', '--json', 'out/r.json', '--html', 'out/r.html', '--junit',
                 'out/r.xml')
    assert judged.code == 0, judged
    assert 'written: out/r.xml\nnext: ur5 view bags/mine' in judged.out and judged.err == ''
    result = json.loads((tmp_path / 'out' / 'r.json').read_text())
    assert result['about']['folder'].endswith('mine')
    assert result['verdict'] == 'pass' and len(result['checks']) >= 10
    assert '<script' in (tmp_path / 'out' / 'r.html').read_text()
    suite = ElementTree.parse(tmp_path / 'out' / 'r.xml').getroot()
    assert int(suite.get('tests')) == len(result['checks']) and suite.get('failures') == '0'


def test_validate_all_judges_every_run_below_a_folder(ur5, short_run, cut_run, tmp_path):
    shutil.copytree(short_run, tmp_path / 'good')
    (tmp_path / 'noise').mkdir()
    (tmp_path / 'noise' / 'x_0.mcap').write_bytes(b'nothing of the kind')
    judged = ur5('validate', '--all', '.', '--json', 'all.json', '--junit', 'all.xml')
    assert judged.code == 1, judged
    verdicts = {run['folder']: run['verdict']
                for run in json.loads((tmp_path / 'all.json').read_text())['runs']}
    assert verdicts == {'good': 'pass', 'cut': 'fail', 'noise': 'unreadable'}
    assert '1 of 3 runs passed' in judged.out
    suite = ElementTree.parse(tmp_path / 'all.xml').getroot()
    assert (suite.get('failures'), suite.get('errors')) == ('1', '1')
    assert ur5('validate', '--all', 'good').code == 0
    assert ur5('validate', '--all', 'noise').code == 2


def test_own_pass_marks_judge_one_run_and_a_folder(ur5, short_run, tmp_path):
    shutil.copytree(short_run, tmp_path / 'runs' / 'mine')
    marks = tmp_path / 'strict.yaml'
    marks.write_text('name: strict\nmarks:\n  residual:\n    limit: 1.0e-16\n    unit: N m\n'
                     '    reason: tried in a test\n')
    judged = ur5('validate', 'runs/mine', '--marks', 'strict.yaml', '--json', 'one.json')
    assert judged.code == 1, judged
    output = json.loads((tmp_path / 'one.json').read_text())
    assert output['about']['marks'] == 'strict'
    assert {check['limit'] for check in output['checks'] if 'residual' in check['name']} == {1e-16}
    assert ur5('validate', '--all', 'runs', '--marks', 'strict.yaml').code == 1
    wrong = tmp_path / 'wrong.yaml'
    wrong.write_text(marks.read_text().replace('residual', 'residul'))
    refused = ur5('validate', 'runs/mine', '--marks', 'wrong.yaml')
    assert refused.code == 2 and len(refused.err.splitlines()) == 1
    assert "'residul'" in refused.err and 'residual' in refused.err
    missing = ur5('validate', 'runs/mine', '--marks', 'none.yaml')
    assert missing.code == 2 and 'none.yaml' in missing.err


def test_a_cut_run_is_judged_as_far_as_it_goes_and_repaired(ur5, cut_run, tmp_path):
    before = {path: path.read_bytes() for path in cut_run.rglob('*.mcap')}
    assert ur5('validate', 'cut').code == 1
    mended = ur5('recover', 'cut', '-o', 'mended', '--json', 'mended.json')
    assert mended.code == 3, mended
    output = json.loads((tmp_path / 'mended.json').read_text())
    assert output['intact'] is False and output['bags']['sim']['problems']
    assert output['out'].endswith('mended')
    assert {path: path.read_bytes() for path in cut_run.rglob('*.mcap')} == before
    bag = open_bag(tmp_path / 'mended' / 'sim')
    assert bag.check() == []
    assert 800 < len(bag.columns('/joint_states').log_time) < 1500
    whole = ur5('recover', 'mended')
    assert whole.code == 0 and 'nothing to repair' in whole.out


def test_resimulate_and_recontrol_say_yes_to_the_bit(ur5, short_run, tmp_path):
    for command, what in (('resimulate', 'states'), ('recontrol', 'commands')):
        repeated = ur5(command, short_run, '--json', 'repeated.json')
        assert repeated.code == 0, repeated
        assert f'1500 {what} equal to the last bit' in repeated.out
        assert json.loads((tmp_path / 'repeated.json').read_text())['equal'] is True


def test_compare_distinguishes_two_runs(ur5, short_run, tmp_path):
    run_closed_loop(run_config(duration=1.5, sim={'payload.mass': 0.1}), tmp_path / 'heavy')
    parted = ur5('compare', short_run, 'heavy', '--json', 'c.json')
    assert parted.code == 1
    assert 'payload.mass: 0.0 and 0.1' in parted.out and 'different runs' in parted.out
    found = json.loads((tmp_path / 'c.json').read_text())
    assert found['same'] is False and found['verdicts'] == ['pass', 'fail']
    assert ur5('compare', short_run, short_run).code == 0


def test_urdf_is_the_same_that_the_simulator_publishes(ur5, short_run):
    printed = ur5('urdf', '--arm', 'ur5')
    assert printed.code == 0
    _, message = next(open_bag(short_run / 'sim').messages('/robot_description'))
    assert printed.out.rstrip() == message['data'].rstrip()
    assert '<joint name="left_elbow_joint"' in ur5('urdf', '--tf-prefix', 'left_').out


def test_render_draws_a_picture(ur5, short_run, tmp_path):
    assert ur5('render', short_run, '-o', 'run.png').code == 0
    assert (tmp_path / 'run.png').read_bytes().startswith(b'\x89PNG')


@pytest.fixture
def log(short_run, tmp_path):
    """The run as a robot's own log would have it, at 125 Hz."""
    run, arm = load_run(short_run), load_arm('ur5')
    target = inverse_dynamics(*run.reference, arm)
    columns = {'t': run.t[:, None], 'q_target': run.reference.q, 'qd_target': run.reference.qd,
               'qdd_target': run.reference.qdd, 'm_target': target,
               'q_actual': run.states.q, 'qd_actual': run.states.qd}
    names = [name if name == 't' else f'{name}_{joint}'
             for name, values in columns.items() for joint in range(1, values.shape[1] + 1)]
    file = tmp_path / 'log.csv.gz'
    with gzip.open(file, 'wt') as text:
        np.savetxt(text, np.hstack(list(columns.values()))[::8], delimiter=',', fmt='%.17g',
                   header=','.join(names), comments='')
    return file


def test_import_makes_a_bag_that_validate_judges(ur5, log, tmp_path):
    made = ur5('import', log, '--out', 'robot', '--arm', 'ur5')
    assert made.code == 0 and 'written: robot' in made.out, made
    judged = ur5('validate', 'robot', '--json', 'robot.json')
    assert judged.code in (0, 1), judged
    checks = {check['name']: check['verdict']
              for check in json.loads((tmp_path / 'robot.json').read_text())['checks']}
    assert checks['inverse dynamics'] == 'pass' and checks['timing'] == 'pass', judged.out
    again = ur5('import', log, '--out', 'robot')
    assert again.code == 2 and 'robot' in again.err


def test_import_refuses_what_is_no_log(ur5, tmp_path):
    (tmp_path / 'notes.csv').write_text('t,mood\n0.0,good\n')
    refused = ur5('import', 'notes.csv', '--out', 'robot')
    assert refused.code == 2 and 'notes.csv' in refused.err
    assert not (tmp_path / 'robot').exists()


def test_identify_finds_the_arm_and_writes_a_file_that_validate_takes(ur5, tmp_path):
    for name, experiment in (('exciting', 'exciting'), ('other', 'multi_sine')):
        run_closed_loop(run_config(experiment, duration=15.0), tmp_path / name)
    found = ur5('identify', 'exciting', '--test', 'other', '-o', 'found.yaml', '--json', 'f.json')
    assert found.code == 0, found
    result = json.loads((tmp_path / 'f.json').read_text())
    assert max(result['test']['error_rms']) < 1e-6
    judged = ur5('urdf', '--arm', 'found.yaml')
    assert judged.code == 0 and '<robot' in judged.out
    again = ur5('identify', 'exciting', '-o', 'found.yaml')
    assert again.code == 2 and 'found.yaml' in again.err


def test_after_a_warm_up_a_demo_and_its_verdict_compile_nothing(ur5, tmp_path, times):
    folder = tmp_path / 'kernels'
    if times(False, True):  # from nothing
        ur5.environment['NUMBA_CACHE_DIR'] = str(folder)
        assert '13 of 13 kernels compiled' in ur5.process('warm-up').out
    else:
        ur5.process('warm-up')
    compiled = sorted(folder.rglob('*.nbc'))
    assert '0 of 13 kernels compiled' in ur5.process('warm-up').out
    demo = ur5.process('demo', '--composed', '--run', 'run')
    assert demo.code == 0 and 'compiling' not in demo.err
    wrong = ur5.process('demo', '--composed', '--control-arm', 'ur5_description', '--run', 'wrong')
    assert wrong.code == 1 and 'cause: the plant moves as arm ur5' in wrong.out
    assert 'compiling' not in wrong.err, 'nor does a verdict that names its cause'
    assert 'compiled' not in (tmp_path / 'run' / 'closed_loop.log').read_text()
    assert sorted(folder.rglob('*.nbc')) == compiled
