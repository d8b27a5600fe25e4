"""Arm files from a URDF and from a robot's calibration, and what is refused with its reason."""

import re
from dataclasses import replace

import numpy as np
import pytest
import yaml

from ur5_ros.config import list_arms, load_arm
from ur5_ros.config.arm_writer import arm_file_text
from ur5_ros.config.arms import parse_arm
from ur5_ros.config.foreign_arms.calibration import calibrated_arm_text
from ur5_ros.config.foreign_arms.urdf_arm import arm_of_urdf, mass_beyond_tool
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.sim.urdf import urdf_text

ARMS = [name for name in list_arms() if load_arm(name).has_tensors]
LINKS = ('shoulder', 'upper_arm', 'forearm', 'wrist_1', 'wrist_2', 'wrist_3')


@pytest.fixture
def written(tmp_path):
    """Return a function that writes the URDF of an arm, changed, and returns its path."""
    def write(name='ur5e', change=lambda text: text, prefix=''):
        path = tmp_path / 'robot.urdf'
        path.write_text(change(urdf_text(load_arm(name), prefix)))
        return path
    return write


@pytest.mark.parametrize('prefix', ['', 'left_'])
@pytest.mark.parametrize('name', ARMS)
def test_the_arm_of_a_urdf_moves_and_weighs_as_the_urdf_says(written, name, prefix):
    arm, found = load_arm(name), arm_of_urdf(written(name, prefix=prefix))
    found = replace(found, gravity=arm.gravity)  # which a URDF does not hold
    q, qd, qdd = np.random.default_rng(2).uniform(-3.0, 3.0, (3, 30, 6))
    np.testing.assert_allclose(forward_kinematics(q + found.angle_offset, found),
                               forward_kinematics(q + arm.angle_offset, arm), atol=1e-12)
    torque = inverse_dynamics(q + arm.angle_offset, qd, qdd, arm) - arm.armature * qdd
    np.testing.assert_allclose(inverse_dynamics(q + found.angle_offset, qd, qdd, found), torque,
                               atol=1e-9 * np.abs(torque).max())
    np.testing.assert_array_equal(found.limits.upper, arm.limits.upper)


def test_the_file_of_an_arm_of_a_urdf_loads_to_the_same_arm(written):
    found = arm_of_urdf(written())
    again = parse_arm(arm_file_text(found, 'd', 'a', 'b'), 'text')
    for part in ('a', 'd', 'mass', 'com', 'inertia', 'angle_offset'):
        np.testing.assert_array_equal(getattr(again, part), getattr(found, part))


def another(old, new, count=1):
    def change(text):
        assert re.search(old, text, re.DOTALL)
        return re.sub(old, new, text, count=count, flags=re.DOTALL)
    return change


def rounded(digits, cut=False):
    """Return a change that writes every angle with a few digits, as other tools do."""
    def write(found):
        words = (f'{float(each):.{digits + 3 * cut}f}'[:-3 if cut else None]
                 for each in found[1].split())
        return f'rpy="{" ".join(words)}"'
    return lambda text: re.sub('rpy="([^"]*)"', write, text)


@pytest.mark.parametrize('change', [
    rounded(2), rounded(4), rounded(6), rounded(4, cut=True), rounded(5, cut=True),
    lambda text: text.replace('\n', '\r\n'), lambda text: f'\ufeff{text.partition("?>")[2]}',
    lambda text: text.replace('_joint"', '_axis"')])
def test_right_angles_of_few_digits_and_other_names_give_the_same_arm(written, change):
    arm, found = load_arm('ur5e'), arm_of_urdf(written(change=change))
    np.testing.assert_allclose(found.a, arm.a, atol=1e-15)
    np.testing.assert_allclose(found.d, arm.d, atol=1e-15)
    q = np.random.default_rng(3).uniform(-3.0, 3.0, (5, 6))
    np.testing.assert_allclose(forward_kinematics(q + found.angle_offset, found),
                               forward_kinematics(q, arm), atol=1e-12)


def test_an_angle_that_is_no_rounded_right_angle_is_refused_as_it_is(written):
    change = another('elbow_joint"(.*?)<origin xyz="([^"]*)" rpy="[^"]*"',
                     r'elbow_joint"\1<origin xyz="\2" rpy="0.0003 0 0"')
    with pytest.raises(InputError, match='axes 2 and 3 are not parallel'):
        arm_of_urdf(written(change=change))


HAND = """<link name="hand"><inertial><mass value="0.9"/><origin xyz="0 0 0.05"/><inertia
ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="finger"><inertial><mass value="0.3"/></inertial></link>
<joint name="hand_joint" type="fixed"><parent link="tool0"/><child link="hand"/></joint>
<joint name="finger_joint" type="revolute"><parent link="hand"/><child link="finger"/></joint>
</robot>"""


def test_a_fixed_hand_belongs_to_the_arm_and_its_moving_fingers_are_counted(written):
    path = written(change=lambda text: text.replace('</robot>', HAND))
    assert arm_of_urdf(path).mass[5] == pytest.approx(load_arm('ur5e').mass[5] + 0.9)
    assert mass_beyond_tool(path) == pytest.approx(0.3)
    assert mass_beyond_tool(written()) == 0.0


@pytest.mark.parametrize('change, reason', [
    (lambda text: text[:500], 'not XML'),
    (lambda text: '<mujoco/>', 'its root is <mujoco>'),
    (lambda text: '<!DOCTYPE x [<!ENTITY a "b">]>' + text.partition('?>')[2], 'declares entities'),
    (lambda text: text.replace('name="', 'name="${prefix}', 1), 'xacro'),
    (another('type="revolute"', 'type="fixed"'), '5 revolute joints'),
    (another('type="(revolute|continuous)"', 'type="prismatic"', 6), '0 revolute joints'),
    (another('wrist_2_joint"(.*?)<origin xyz="[^"]*" rpy="[^"]*"',
             r'wrist_2_joint"\1<origin xyz="0 0 0.1" rpy="1.2 0 0"'),
     'axes 4 and 5 are not perpendicular'),
    (another('elbow_joint"(.*?)<origin xyz="([^"]*)" rpy="[^"]*"',
             r'elbow_joint"\1<origin xyz="\2" rpy="0.1 0 0"'), 'axes 2 and 3 are not parallel'),
    (another('shoulder_lift_joint"(.*?)<origin xyz="[^"]*"',
             r'shoulder_lift_joint"\1<origin xyz="0.05 0 0"'), 'axes 1 and 2 pass each other'),
    (another('<mass value="[1-9.]+[^"]*"/>', '<mass value="0"/>'), 'has no mass'),
    (another('velocity="[^"]*"', ''), 'needs <limit>'),
    (another('velocity="[^"]*"', 'velocity="inf"'), "velocity='inf'; a limit needs"),
    (another('effort="[^"]*"', 'effort="0"'), "effort='0'.*a limit needs"),
    (another('lower="[^"]*"', 'lower="9"'), 'lower below upper'),
    (another('elbow_joint"(.*?)<axis xyz="[^"]*"', r'elbow_joint"\1<axis xyz="0 0 0"'),
     'its axis is 0 0 0'),
    (another('<mass value="[1-9.]+[^"]*"/>', '<mass value="heavy"/>'), "value='heavy'; give a "),
    (another('ixx="[^"]*"', 'ixx="nan"', 99), "ixx='nan'; give a finite number"),
    (another('elbow_joint"(.*?)<origin xyz="[^"]*"', r'elbow_joint"\1<origin xyz="a b c"'),
     'three finite numbers')])
def test_a_urdf_of_another_kind_is_refused_with_the_reason(written, change, reason):
    with pytest.raises(InputError, match=reason) as caught:
        arm_of_urdf(written(change=change))
    assert '\n' not in str(caught.value) and 'robot.urdf' in str(caught.value)


def calibration(name, size=1e-3, seed=1):
    """Return what ur_calibration writes for an arm that is off by about a millimetre."""
    arm, random = load_arm(name), np.random.default_rng(seed)
    half = np.pi / 2
    nominal = {'shoulder': (0, 0, arm.d[0], 0, 0, 0), 'upper_arm': (0, 0, 0, half, 0, 0),
               'forearm': (arm.a[1], 0, 0, 0, 0, 0),
               'wrist_1': (arm.a[2], 0, arm.d[3], 0, 0, 0),
               'wrist_2': (0, -arm.d[4], 0, half, 0, 0),
               'wrist_3': (0, arm.d[5], 0, half, np.pi, np.pi)}
    return {'kinematics': {**{
        link: dict(zip(('x', 'y', 'z', 'roll', 'pitch', 'yaw'),
                       (float(x) for x in np.add(values, random.normal(0.0, size, 6))),
                       strict=True)) for link, values in nominal.items()},
        'hash': 'calib_123'}}


@pytest.mark.parametrize('given', [True, False])
@pytest.mark.parametrize('name', ['ur3e', 'ur5e', 'ur16e'])
def test_a_calibration_becomes_an_arm_file_that_follows_it(tmp_path, name, given):
    path = tmp_path / 'calibration.yaml'
    path.write_text(yaml.safe_dump(calibration(name)))
    text, sentences = calibrated_arm_text(path, name if given else None)
    arm = parse_arm(text, 'text')
    assert arm.calibration is not None and 'calib_123' in text and 'the tool moves' in sentences[0]
    q = np.random.default_rng(4).uniform(-3.0, 3.0, (20, 6))
    away = np.linalg.norm(forward_kinematics(q, arm)[:, :3, 3]
                          - forward_kinematics(q, load_arm(name))[:, :3, 3], axis=1)
    assert 1e-4 < away.max() < 0.02
    if not given:
        assert np.abs(arm.a - load_arm(name).a).max() == 0.0  # of the same geometry, at least
    np.testing.assert_array_equal(inverse_dynamics(q, q, q, arm), inverse_dynamics(
        q, q, q, parse_arm(text.partition('\ncalibration:')[0] + '\n', 'text')))


@pytest.mark.parametrize('change', [
    lambda data: data.update(hardware='ur5e'), lambda data: data['kinematics'].update(hash=1234),
    lambda data: data['kinematics'].pop('hash')])
def test_what_a_calibration_holds_besides_does_no_harm(tmp_path, change):
    data = calibration('ur5e')
    change(data)
    path = tmp_path / 'calibration.yaml'
    path.write_text(yaml.safe_dump(data))
    assert parse_arm(calibrated_arm_text(path)[0], 'text').calibration is not None


@pytest.mark.parametrize('change, reason', [
    (lambda data: data['kinematics'].pop('forearm'), 'forearm'),
    (lambda data: data['kinematics']['forearm'].update(x='left'), 'x'),
    (lambda data: data['kinematics']['forearm'].update(x=float('nan')), 'x'),
    (lambda data: data['kinematics']['forearm'].update(x=-0.6),
     'at most 0.05 m are a calibration'),
    (lambda data: data.clear(), 'kinematics')])
def test_a_file_that_is_no_calibration_of_the_arm_is_refused(tmp_path, change, reason):
    data = calibration('ur5e')
    change(data)
    path = tmp_path / 'calibration.yaml'
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(InputError, match=reason) as caught:
        calibrated_arm_text(path, 'ur5e')
    assert '\n' not in str(caught.value) and 'calibration.yaml' in str(caught.value)
