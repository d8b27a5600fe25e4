"""Arm files: every number sourced, every body physical, every mistake refused in one line."""

import itertools
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from ur5_ros.config import arm_text, config_folder, list_arms, load_arm, parse_arm
from ur5_ros.config.arms import ASSUMED, arms_with_assumed_armature
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import with_payload

REPO = Path(__file__).resolve().parents[2]
DATA = REPO / 'test' / 'data'
PROMISED = {'ur5', 'ur5_kebria2016', 'ur5_description', 'ur5_controller', 'ur5_real', 'ur3',
            'ur10', 'ur3e', 'ur5e', 'ur7e', 'ur8long', 'ur10e', 'ur12e', 'ur15', 'ur16e', 'ur18',
            'ur20', 'ur30', 'ur5e_real', 'ur10e_real', 'ur10e_controller', 'ur10_measured'}


def test_every_promised_arm_is_there():
    assert set(list_arms()) == PROMISED


@pytest.mark.parametrize('name', sorted(PROMISED))
def test_every_block_of_numbers_names_its_source(name):
    data = yaml.safe_load(arm_text(name))
    blocks = [data[key] for key in ('dh', 'angle_offset', 'armature', 'gravity', 'limits')]
    for block in blocks + data['links']:
        assert len(block['source']) > 15


@pytest.mark.parametrize('name', sorted(PROMISED))
def test_record_is_frozen_and_named(name):
    arm = load_arm(name)
    assert arm.name == name
    with pytest.raises(ValueError, match='read-only'):
        arm.mass[0] = 1.0
    assert arm.has_tensors == (name != 'ur5_controller')


@pytest.mark.parametrize('name', ['ur3', 'ur10', 'ur3e', 'ur5e', 'ur10e', 'ur16e', 'ur20',
                                  'ur30', 'ur5_description'])
def test_family_numbers_equal_the_published_table(name):
    robots = json.loads((DATA / 'ur_family.json').read_text())['robots']
    robot = robots['ur5' if name == 'ur5_description' else name]
    arm = load_arm(name)
    assert np.array_equal(arm.a, robot['dh_manufacturer']['a'])
    assert np.array_equal(arm.d, robot['dh_manufacturer']['d'])
    for i, link in enumerate(robot['links']):
        assert arm.mass[i] == link['mass']
        assert np.array_equal(arm.com[i], link['com_manufacturer_std_dh_frame'])
        assert np.array_equal(arm.inertia[i], link['inertia_com_std_dh_axes'])


def test_payload_moves_the_common_centre_of_mass_and_keeps_the_moment():
    arm = load_arm('ur5')
    loaded = with_payload(arm, 2.0, [0.0, 0.01, 0.05], np.diag([0.01, 0.012, 0.013]))
    mass, com, inertia = loaded.bodies
    assert mass[5] == arm.mass[5] + 2.0
    moment = arm.mass[5] * arm.com[5] + 2.0 * np.array([0.0, 0.01, 0.05])
    assert np.allclose(mass[5] * com[5], moment, atol=1e-15)
    # the second moment about the frame's origin is the sum of the bodies' own
    def about_origin(m, c, tensor):
        return tensor + m * (c @ c * np.eye(3) - np.outer(c, c))
    parts = (about_origin(arm.mass[5], arm.com[5], arm.inertia[5])
             + about_origin(2.0, np.array([0.0, 0.01, 0.05]), np.diag([0.01, 0.012, 0.013])))
    assert np.allclose(about_origin(mass[5], com[5], inertia[5]), parts, atol=1e-15)


def mutated(path: list, value) -> str:
    data = yaml.safe_load(arm_text('ur5'))
    node = data
    for key in path[:-1]:
        node = node[key]
    if value is None:
        del node[path[-1]]
    else:
        node[path[-1]] = value
    return yaml.safe_dump(data)


@pytest.mark.fault(38, 40, 41, 42, 44, 45)
@pytest.mark.parametrize(('path', 'value', 'words'), [
    (['links', 2, 'mass'], None, 'missing required field `mass` - at `$.links[2]`'),
    (['links', 2, 'mass'], -2.275, 'mass of link 3 is -2.275 kg; give more than zero'),
    (['links', 2, 'mass'], float('nan'), '$.links[2].mass'),
    (['links', 2, 'mass'], '2,275', '$.links[2].mass'),
    (['links', 1, 'inertia'], [0.0078, 0.0021, 0.0021, 0.0, 0.0, 0.0], 'sum of the others'),
    (['links', 1, 'inertia'], [0.0078, -0.21, 0.21, 0.0, 0.0, 0.0], 'principal moment'),
    (['links', 1, 'inertia'], [0.0] * 6, 'point mass'),
    (['armature', 'value'], [-1.0] + [0.0] * 5, 'armature'),
    (['dh', 'a'], [0.0] * 6, 'a2, a3'),
    (['dh', 'alpha'], [0.0] * 6, 'UR twists'),
    (['dh', 'b'], [0.0] * 6, 'unknown field `b` - at `$.dh`'),
    (['limits', 'effort'], [150.0] * 5 + [0.0], 'effort limit of joint 6'),
    (['limits', 'position'], [[1.0, -1.0] for _ in range(6)], 'lower must be less'),
    (['gravity', 'value'], [0.0, 0.0], 'gravity.value'),
    (['links'], [], '`array` of length >= 6 - at `$.links`'),
    (['limits', 'velocity'], None, 'missing required field `velocity` - at `$.limits`'),
])
def test_a_file_that_is_no_arm_is_refused_in_one_line(path, value, words):
    with pytest.raises(InputError, match=re.escape(words)) as refusal:
        parse_arm(mutated(path, value), 'my_arm.yaml')
    message = str(refusal.value)
    assert message.startswith('my_arm.yaml: ')
    assert '\n' not in message


@pytest.mark.fault(31, 38, 39)
@pytest.mark.parametrize(('text', 'words'), [
    ('', 'Expected `object`, got `null`'),
    ('a: 1\na: 2\n', "key 'a' stands twice"),
    ('a: &x [1]\nb: *x\n', 'alias *x'),
    ('a: !!python/object/apply:os.system [ls]\n', 'not valid YAML'),
    ('[' * 5000, 'nested deeper'),
    ('a: [1, 2', 'not valid YAML'),
    ('\x00', 'not valid YAML'),
    ('1: 2', 'is not a text'),
])
def test_hostile_yaml_is_refused_in_one_line(text, words):
    with pytest.raises(InputError, match=re.escape(words)) as refusal:
        parse_arm(text, 'bad.yaml')
    assert '\n' not in str(refusal.value)


def test_an_unknown_arm_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match='unknown arm .ur7.; give one of: ur10, '):
        load_arm('ur7')
    with pytest.raises(InputError, match='no arm file'):
        load_arm('/no/such/arm.yaml')


@given(st.text(max_size=300) | st.binary(max_size=300).map(lambda b: b.decode('latin-1')))
@settings(max_examples=300, deadline=None)
def test_no_text_gets_past_the_parser_as_anything_but_a_refusal(text):
    with pytest.raises(InputError):
        parse_arm(text, 'fuzz.yaml')


def test_the_folder_found_is_the_one_of_this_checkout():
    assert config_folder() == REPO / 'config'


def test_both_parsers_of_yaml_say_the_same():
    read = """
import sys
{}
from ur5_ros.config import arm_text, list_arms, parse_yaml
print([parse_yaml(arm_text(name), name) for name in list_arms()])
"""
    printed = [subprocess.run([sys.executable, '-c', read.format(first)], check=True,
                           capture_output=True, text=True).stdout
            for first in ('', 'sys.modules["yaml._yaml"] = None\nsys.modules["_yaml"] = None')]
    assert printed[0] == printed[1] != ''


@pytest.mark.parametrize('name', arms_with_assumed_armature())
def test_assumed_rotors_replace_none_and_are_named_in_the_text(name):
    base, arm = load_arm(name.removesuffix(ASSUMED)), load_arm(name)
    assert not base.armature.any() and (arm.armature > 0.0).all()
    assert arm.name == name
    assert_array_equal(parse_arm(arm_text(name), 'a bag').armature, arm.armature)
    assert 'armature_assumed' not in arm_text(name).partition('armature:')[2]
    for field in ('a', 'd', 'mass', 'com', 'inertia'):
        assert_array_equal(getattr(base, field), getattr(arm, field))


def test_an_arm_without_assumed_rotors_says_which_have_them():
    with pytest.raises(InputError, match='ur10e.armature_assumed'):
        load_arm('ur5_real+armature_assumed')


def test_assumed_rotors_grow_with_the_torque_of_the_joint():
    pairs = sorted((effort, inertia) for name in arms_with_assumed_armature()
                   for effort, inertia in zip(load_arm(name).limits.effort,
                                              load_arm(name).armature, strict=True))
    for (effort, inertia), (other, more) in itertools.pairwise(pairs):
        assert more >= inertia * (0.98 if other == effort else 1.0)


#: Torque limit [N m] and rotor inertia [kg m^2] measured on a UR5 and a UR10e.
MEASURED_ROTORS = ((28.0, 0.1598), (54.0, 0.61), (150.0, (1.915 + 1.95) / 2.0), (330.0, 6.1))


def test_assumed_rotors_follow_the_power_laws_through_what_was_measured():
    torque, inertia = np.log(np.array(MEASURED_ROTORS)).T
    slopes = np.diff(inertia) / np.diff(torque)
    for name in set(arms_with_assumed_armature()) - {'ur10e' + ASSUMED}:  # measured itself
        limit = np.log(load_arm(name).limits.effort)
        first = np.clip(np.searchsorted(torque, limit, side='right') - 1, 0, len(slopes) - 1)
        law = np.exp(inertia[first] + slopes[first] * (limit - torque[first]))
        assert_allclose(load_arm(name).armature, law, rtol=5e-3, err_msg=name)


def test_every_arm_without_rotors_has_assumed_ones():
    without = {name for name in list_arms() if not load_arm(name).armature.any()}
    assert {name.removesuffix(ASSUMED) for name in arms_with_assumed_armature()} == (
        without - {'ur5', 'ur5_description', 'ur5_kebria2016'})  # measured: ur5_real


@pytest.mark.parametrize('name, gravity', [('ur10e_controller', -9.82), ('ur10e_real', -9.81)])
def test_the_arms_of_a_real_ur10e_are_the_published_one_with_rotors(name, gravity):
    arm, published = load_arm(name), load_arm('ur10e')
    for field in ('a', 'd', 'mass', 'com', 'inertia'):
        assert np.array_equal(getattr(arm, field), getattr(published, field))
    assert arm.gravity[2] == gravity and np.all(arm.armature > 0.5)
    # gears of one size have rotors of one inertia: joints 1 and 2, and the three wrists
    assert arm.armature[0] == arm.armature[1] and len(set(arm.armature[3:].tolist())) == 1


def test_the_measured_friction_of_a_ur10_is_that_of_others_on_the_same_recording():
    arm = load_arm('ur10_measured')
    # outside witness: a least squares of others [N m]
    np.testing.assert_allclose(arm.friction.coulomb, [13.6, 14.6, 8.7, 3.0, 2.4, 2.6], rtol=0.10)
    assert arm.has_tensors
