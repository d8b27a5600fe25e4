"""The arm of a recording by the URDF in it: known, calibrated, with a hand, of another robot."""

import re

import numpy as np
import pytest
from command import Command
from foreign_recordings import JOINT_STATE, START, arm_messages, message, motion, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.cdr.fixed_messages import encode_string
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.urdf import urdf_text

TEXT = 'std_msgs/msg/String'


@pytest.fixture
def recorded(tmp_path):
    """Return a function that writes joint states and a robot description as a bag."""
    def record(messages, urdf, topic='/robot_description', **more):
        topics = {'/joint_states': messages, topic: [(START, encode_string(urdf))], **more}
        return write_bag(tmp_path / 'bag', topics, {
            name: TEXT if name.endswith('description') else JOINT_STATE for name in topics})
    return record


def calibrated(urdf, size=5e-4):
    """Return a URDF whose joints stand where a calibration puts them, about a millimetre off."""
    random = np.random.default_rng(3)

    def move(found):
        values = [[float(x) + random.normal(0.0, size) for x in part.split()]
                  for part in found.groups()[1:]]
        xyz, rpy = (' '.join(map(repr, each)) for each in values)
        return f'{found[1]}xyz="{xyz}" rpy="{rpy}"'
    return re.sub(r'(_joint" type="(?:revolute|continuous)">.*?<origin )xyz="([^"]*)" '
                  r'rpy="([^"]*)"', move, urdf, flags=re.DOTALL)


@pytest.mark.parametrize('name', ['ur5e', 'ur3', 'ur20'])
def test_a_known_arm_in_the_bag_is_taken_without_an_option(recorded, name):
    run = load_run(recorded(arm_messages(motion(name)), urdf_text(load_arm(name))))
    assert run.law_record.arm_name == name
    assert f'the arm is {name}, whose kinematics and inertias /robot_description' in (
        '; '.join(run.remarks))
    assert validate(run).verdict == 'pass'


def test_a_calibrated_arm_is_the_known_one_and_its_distance_is_said(recorded, made):
    urdf = calibrated(urdf_text(load_arm('ur5e')))
    run = load_run(recorded(arm_messages(made), urdf))
    assert run.law_record.arm_name == 'ur5e'
    assert re.search(r'the tool within [1-9][.\d]* mm', '; '.join(run.remarks))


def test_each_of_two_arms_finds_its_own_description(recorded, made):
    left, right = arm_messages(made), arm_messages(motion('ur3e'))
    folder = recorded(left, urdf_text(load_arm('ur5e')), '/left/robot_description', **{
        '/right/robot_description': [(START, encode_string(urdf_text(load_arm('ur3e'))))],
        '/right/joint_states': right})
    run = load_run(folder, topics={'joint_states': '/right/joint_states'})
    assert run.law_record.arm_name == 'ur3e'


def test_of_two_arms_in_one_description_the_prefix_chooses(recorded, made):
    other = motion('ur3e')
    names = [prefix + name for prefix in ('l_', 'r_') for name in JOINT_NAMES]
    messages = [(int(stamp), message(stamp, names, *(
        np.concatenate([getattr(each, part)[k] for each in (made, other)])
        for part in ('q', 'qd', 'effort')))) for k, stamp in enumerate(made.stamp)]
    both = '<robot name="pair">' + ''.join(
        re.search('<robot[^>]*>(.*)</robot>', urdf_text(load_arm(name), prefix), re.DOTALL)[1]
        for name, prefix in (('ur5e', 'l_'), ('ur3e', 'r_'))) + '</robot>'
    folder = recorded(messages, both)
    for prefix, name in (('l_', 'ur5e'), ('r_', 'ur3e')):
        run = load_run(folder, joint_prefix=prefix)
        assert run.law_record.arm_name == name
        assert validate(run).verdict == 'pass'


def test_an_option_comes_before_the_description_and_the_difference_is_said(recorded, made):
    run = load_run(recorded(arm_messages(made), urdf_text(load_arm('ur10e'))), arm='ur5e')
    assert run.law_record.arm_name == 'ur5e'
    assert any('the arm is ur10e' in each and 'arm ur5e was taken' in each
               for each in run.remarks)


HAND = """<link name="hand"><inertial><mass value="0.9"/><origin xyz="0 0 0.05"/><inertia
ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hand_joint" type="fixed"><parent link="tool0"/><child link="hand"/></joint></robot>"""


def test_an_arm_with_a_hand_is_named_and_its_arm_file_is_made_of_the_bag(recorded, made, tmp_path):
    ur5 = Command(tmp_path)
    folder = recorded(arm_messages(made),
                      urdf_text(load_arm('ur5e')).replace('</robot>', HAND))
    found = ur5('validate', folder)
    assert found.code == 2 and found.err.count('\n') == 1
    assert 'has the lengths of ur5e and other masses' in found.err
    assert f'ur5 arm --urdf {folder} -o arm.yaml' in found.err
    arm = tmp_path / 'arm.yaml'
    assert ur5('arm', '--urdf', folder, '-o', arm).code == 0
    assert load_arm(str(arm)).mass[5] == pytest.approx(load_arm('ur5e').mass[5] + 0.9)
    run = load_run(folder, arm=str(arm))
    assert 'inverse dynamics' in [check.name for check in validate(run).checks]


@pytest.mark.parametrize('urdf, reason', [
    ('', 'not XML'), ('<robot name="x"/>', '0 revolute joints'),
    ('<robot name="${x}"/>', 'a xacro file')])
def test_a_description_of_another_kind_is_no_reason_to_refuse_a_stated_arm(
        recorded, made, urdf, reason):
    folder = recorded(arm_messages(made), urdf)
    with pytest.raises(InputError, match=f'no arm is known; give one: --arm NAME.*{reason}'):
        validate(load_run(folder))
    assert validate(load_run(folder, arm='ur5e')).verdict == 'pass'


def test_a_bag_without_a_description_makes_no_arm(made, tmp_path):
    folder = write_bag(tmp_path / 'plain', {'/joint_states': arm_messages(made)})
    found = Command(tmp_path)('arm', '--urdf', folder, '-o', tmp_path / 'arm.yaml')
    assert found.code == 2 and 'no /robot_description in it' in found.err
