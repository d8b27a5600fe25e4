"""The command ``ur5 arm``: the list, an arm file from a URDF, one from a calibration."""

import numpy as np
import yaml

from ur5_ros.config import list_arms, load_arm
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.sim.urdf import urdf_text

CALIBRATION = {'kinematics': {
    link: dict(zip(('x', 'y', 'z', 'roll', 'pitch', 'yaw'), values, strict=True))
    for link, values in {
        'shoulder': (0.0, 0.0, 0.1627, 0.0, 0.0, 1e-5),
        'upper_arm': (1e-4, 0.0, 0.0, 1.5705, 0.0, 0.0),
        'forearm': (-0.4249, 0.0, 0.0, 0.0019, 0.0007, 0.0),
        'wrist_1': (-0.3924, 0.0, 0.1332, -0.001, 0.0, 0.0),
        'wrist_2': (0.0, -0.0998, 1e-4, 1.5712, 0.0, 0.0),
        'wrist_3': (0.0, 0.0995, 1e-4, 1.5709, 3.14159, 3.14155)}.items()}}


def test_the_arms_are_listed(ur5):
    listed = ur5('arm')
    assert listed.code == 0
    header, *rows = listed.out.splitlines()
    assert header.split() == ['arm', 'rotors', 'description']
    named = [row.split()[0] for row in rows if row[0] != ' ']
    found = [name for name in named if name in list_arms()]
    assert sorted(found) == list_arms()
    assert found.index('ur3') < found.index('ur5') < found.index('ur10'), 'by size, not by letter'


def test_an_arm_file_from_a_urdf_serves_every_command(ur5, tmp_path):
    (tmp_path / 'mine.urdf').write_text(urdf_text(load_arm('ur3e')))
    made = ur5('arm', '--urdf', 'mine.urdf', '-o', 'mine.yaml')
    assert made.code == 0 and 'written: mine.yaml' in made.out
    assert load_arm(str(tmp_path / 'mine.yaml')).name == 'mine'
    assert ur5('urdf', '--arm', 'mine.yaml').code == 0
    again = ur5('arm', '--urdf', 'mine.urdf', '-o', 'mine.yaml')
    assert again.code == 2 and 'exists already' in again.err


def test_an_arm_file_from_a_calibration(ur5, tmp_path):
    (tmp_path / 'cal.yaml').write_text(yaml.safe_dump(CALIBRATION))
    made = ur5('arm', '--calibration', 'cal.yaml', '--arm', 'ur5e', '-o', 'mine.yaml')
    assert made.code == 0 and 'the tool moves by up to' in made.out
    moved = (forward_kinematics(np.ones(6), load_arm(str(tmp_path / 'mine.yaml')))
             - forward_kinematics(np.ones(6), load_arm('ur5e')))[:3, 3]
    assert 1e-4 < np.linalg.norm(moved) < 1e-2


def test_what_is_missing_is_asked_for_in_one_line(ur5, tmp_path):
    (tmp_path / 'cal.yaml').write_text(yaml.safe_dump(CALIBRATION))
    for options, reason in (
            (['--calibration', 'cal.yaml'], 'give the arm file to write'),
            (['--calibration', 'cal.yaml', '--arm', 'ur10', '-o', 'x.yaml'],
             'that was calibrated'),
            (['--urdf', 'absent.urdf', '-o', 'x.yaml'], 'absent.urdf'),
            (['-o', 'x.yaml'], 'give --urdf FILE or --calibration FILE')):
        refused = ur5('arm', *options)
        assert refused.code == 2 and reason in refused.err and refused.err.count('\n') == 1
        assert not (tmp_path / 'x.yaml').exists()
