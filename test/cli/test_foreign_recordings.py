"""Commands on recordings of other tools: one line where something is missing, no traceback."""

import json
import shutil

import numpy as np
import pytest
from foreign_recordings import arm_messages, motion, write_bag

from ur5_ros.cli.commands import judge
from ur5_ros.cli.run import run
from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import inverse_dynamics


@pytest.fixture(scope='module')
def plain(tmp_path_factory):
    """A bag with joint states alone, of an arm ur5e."""
    return write_bag(tmp_path_factory.mktemp('foreign') / 'plain',
                     {'/joint_states': arm_messages(motion())})


def test_without_an_arm_validate_ends_with_one_line_and_the_arms_that_fit(ur5, plain):
    judged = ur5('validate', str(plain))
    assert judged.code == 2 and judged.out == ''
    assert judged.err.count('\n') == 1 and '--arm NAME' in judged.err and 'ur5e' in judged.err
    assert ur5('validate', str(plain), '--arm', 'ur5e').code == 0
    assert ur5('validate', str(plain), '--arm', 'ur5').code == 1


def test_validate_all_goes_on_after_a_run_that_cannot_be_judged(ur5, plain, short_run, tmp_path):
    shutil.copytree(plain, tmp_path / 'runs' / 'a_plain')
    shutil.copytree(short_run, tmp_path / 'runs' / 'own')
    judged = ur5('validate', '--all', 'runs', '--json', 'all.json')
    verdicts = {run['run']: run['verdict']
                for run in json.loads((tmp_path / 'all.json').read_text())['runs']}
    assert judged.code == 1 and verdicts.pop('a_plain') == 'not judged'
    assert list(verdicts.values()) == ['pass']
    # the option serves the bag that does not state its arm, and no other one
    assert ur5('validate', '--all', 'runs', '--arm', 'ur5e').code == 0


def test_validate_all_takes_unrelated_files_of_a_folder_one_by_one(ur5, plain, tmp_path):
    (tmp_path / 'loose').mkdir()
    for name in ('monday.mcap', 'tuesday.mcap'):
        shutil.copy(next(plain.glob('*.mcap')), tmp_path / 'loose' / name)
    judged = ur5('validate', '--all', 'loose', '--arm', 'ur5e')
    assert judged.code == 0 and '2 of 2 runs passed' in judged.out
    assert ur5('validate', 'loose/monday.mcap', '--arm', 'ur5e').code == 0


def test_identify_refuses_an_effort_that_is_no_torque_and_names_the_option(ur5, tmp_path):
    made = motion()
    write_bag(tmp_path / 'amperes', {'/joint_states': arm_messages(made.with_(
        effort=made.effort / 12.0))})
    refused = ur5('identify', 'amperes', '--arm', 'ur5e')
    assert refused.code == 2 and '--effort current' in refused.err
    assert refused.err.count('\n') == 1


@pytest.mark.parametrize('spoil, arm, reason', [
    (lambda made: made.effort, 'ur10', 'ur5e fits, with 0.00%: give --arm ur5e'),
    (lambda made: made.qd, 'ur5e', 'none of the known arms fits'),
    (lambda made: made.effort[:, [2, 1, 0, 4, 5, 3]], 'ur5e', 'none of the known arms fits')])
def test_identify_refuses_what_is_no_torque_of_the_arm(ur5, tmp_path, spoil, arm, reason):
    made = motion()
    write_bag(tmp_path / 'other', {'/joint_states': arm_messages(made.with_(effort=spoil(made)))})
    refused = ur5('identify', 'other', '--arm', arm, '-o', 'found.yaml')
    assert refused.code == 2 and f'no torque of arm {arm}' in refused.err and reason in refused.err
    assert refused.err.count('\n') == 1 and not (tmp_path / 'found.yaml').exists()


def test_identify_refuses_efforts_of_other_joints_and_names_them(ur5, tmp_path):
    made = motion()
    write_bag(tmp_path / 'other', {'/joint_states': arm_messages(made.with_(
        effort=made.effort[:, [2, 1, 0, 3, 4, 5]]))})
    refused = ur5('identify', 'other', '--arm', 'ur5e', '-o', 'found.yaml')
    assert refused.code == 2 and refused.err.count('\n') == 1
    assert 'exchanged: shoulder_pan_joint, elbow_joint' in refused.err
    assert not (tmp_path / 'found.yaml').exists()


def test_identify_refuses_velocities_that_are_not_those_of_the_positions(ur5, tmp_path):
    made = motion()
    write_bag(tmp_path / 'degrees', {'/joint_states': arm_messages(made.with_(
        qd=np.degrees(made.qd)))})
    refused = ur5('identify', 'degrees', '--arm', 'ur5e', '-o', 'found.yaml')
    assert refused.code == 2 and 'look like degrees a second' in refused.err
    assert refused.err.count('\n') == 1 and not (tmp_path / 'found.yaml').exists()


def test_identify_export_and_compare_report_what_of_a_recording_was_used(ur5, tmp_path):
    made = motion(n=2500)
    q = made.q.copy()
    q[1000:1005] = np.nan
    write_bag(tmp_path / 'holes', {'/joint_states': arm_messages(made.with_(q=q))})
    remark = '5 states of 2500 hold a value that is not a number, from 2 s to 2.008 s: dropped'
    for words in (('identify', 'holes', '--arm', 'ur5e', '--json', 'found.json'),
                  ('export', 'holes', '-o', 'holes.csv'),
                  ('compare', 'holes', 'holes', '--arm', 'ur5e')):
        done = ur5(*words)
        assert done.code == 0 and f'note: holes: {remark}' in done.out, words
    run, = json.loads((tmp_path / 'found.json').read_text())['runs']
    assert (run['states'], run['dropped']) == (2495, 5) and remark in run['notes']


def test_an_export_takes_the_topic_and_the_prefix(ur5, tmp_path):
    made = motion(n=50)
    write_bag(tmp_path / 'two', {'/joint_states': arm_messages(made.with_(q=made.q + 0.5)),
                                 '/b/joint_states': arm_messages(made, prefix='b_')})
    done = ur5('export', 'two', '-o', 'b.csv', '--topic', 'joint_states=/b/joint_states')
    assert done.code == 0, done.err
    assert ur5('export', 'two', '-o', 'c.csv', '--joint-prefix', 'b_').code == 0
    assert (tmp_path / 'b.csv').read_bytes() == (tmp_path / 'c.csv').read_bytes()
    assert ur5('export', 'two', '-o', 'd.csv', '--joint-prefix', 'x_').code == 2


def test_a_joint_that_rests_where_the_result_is_tried_is_named_and_no_nan_is_printed(
        ur5, tmp_path):
    made, arm = motion(n=4000), load_arm('ur5e')
    ending = np.clip((made.t - 5.5) / 0.5, 0.0, 1.0)
    share = 1.0 - ending**3 * (10.0 - 15.0 * ending + 6.0 * ending**2)
    q = made.q.copy()
    q[:, 4] = -1.2 + share * (q[:, 4] + 1.2)
    qd = np.gradient(q, 0.002, axis=0)
    effort = inverse_dynamics(q, qd, np.gradient(qd, 0.002, axis=0), arm) + 0.5 * np.sign(qd)
    write_bag(tmp_path / 'rests', {'/joint_states': arm_messages(
        made.with_(q=q, qd=qd, effort=effort))})
    done = ur5('identify', 'rests', '--arm', 'ur5e', '-o', 'found.yaml')
    assert done.code == 0, done.err
    assert 'in every joint but wrist_2_joint, which move too little there' in done.out
    assert 'nan' not in done.out and 'nan' not in (tmp_path / 'found.yaml').read_text()


def test_identify_of_less_than_a_second_names_what_it_does_not_tell(ur5, tmp_path):
    write_bag(tmp_path / 'short', {'/joint_states': arm_messages(motion(n=340))})
    refused = ur5('identify', 'short', '--arm', 'ur5e', '-o', 'found.yaml')
    assert refused.code == 2 and 'base parameters, too few' in refused.err
    assert refused.err.count('\n') == 1 and not (tmp_path / 'found.yaml').exists()


def test_render_and_compare_take_the_arm_of_a_bag_that_does_not_state_it(ur5, plain, tmp_path):
    assert ur5('render', str(plain), '-o', 'a.png').code == 2
    assert ur5('render', str(plain), '--arm', 'ur5e', '-o', 'a.png').code == 0
    assert (tmp_path / 'a.png').stat().st_size > 1000
    assert ur5('compare', str(plain), str(plain), '--arm', 'ur5e').code == 0


@pytest.mark.parametrize('options, reason', [
    (['--topic', 'states=/joint_states'], 'the roles are: joint_states'),
    (['--topic', 'joint_states'], 'give ROLE=NAME'),
    (['--topic', 'joint_states=/a', '--topic', 'joint_states=/b'], 'given twice'),
    (['--effort', 'ampere'], 'give one of: total'),
    (['--joint-prefix', 'left_'], 'the prefixes there are')])
def test_a_wrong_option_is_refused_in_one_line(ur5, plain, options, reason):
    judged = ur5('validate', str(plain), '--arm', 'ur5e', *options)
    assert judged.code == 2 and reason in judged.err and judged.err.count('\n') == 1


def test_an_unforeseen_error_is_one_line_with_exit_code_4_and_a_file(
        plain, monkeypatch, tmp_path, capsys):
    def broken(*_, **__):
        raise RuntimeError('two\nlines')

    monkeypatch.setattr(judge, 'validate_run', broken)
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    assert run(['validate', str(plain), '--arm', 'ur5e']) == 4
    printed = capsys.readouterr()
    assert printed.out == '' and printed.err.count('\n') == 1
    assert 'internal error (RuntimeError: two lines)' in printed.err and 'report it' in printed.err
    details, = tmp_path.glob('ur5-internal-error-*.txt')
    assert str(details) in printed.err
    assert 'Traceback' in details.read_text() and '--arm' in details.read_text()
