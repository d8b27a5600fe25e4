"""Arm records that no robot can have are refused by name."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.parameters import with_payload


def changed(arm, name, index, value):
    array = getattr(arm, name).copy()
    array[index] = value
    return {name: array}


@pytest.mark.parametrize(('name', 'index', 'value', 'message'), [
    ('a', 0, 0.1, 'a1, a4, a5, a6 are'),
    ('a', 4, 0.1, 'a1, a4, a5, a6 are'),
    ('d', 2, 0.1, 'd2, d3 are'),
    ('a', 1, 0.0, 'a2, a3 are'),
    ('alpha', 0, 0.0, 'alpha is'),
    ('d', 0, np.nan, 'd holds nan'),
    ('mass', 3, 0.0, 'mass of link 4 is 0'),
    ('mass', 3, -1.0, 'mass of link 4 is -1'),
    ('armature', 2, -0.1, 'armature holds -0.1'),
    ('inertia', (1, 0, 1), 0.1, 'inertia of link 2 is not symmetric'),
    ('inertia', (1, 0, 0), -0.1, 'inertia of link 2 has a principal moment of -0.1'),
    ('inertia', (1, 0, 0), 9.0, 'no body has one larger than the sum of the others'),
])
def test_a_record_that_is_not_physical_is_refused(name, index, value, message):
    arm = load_arm('ur5')
    with pytest.raises(ValueError, match=message):
        replace(arm, **changed(arm, name, index, value))


def test_point_masses_need_rotor_inertia():
    arm = load_arm('ur5_controller')
    with pytest.raises(ValueError, match='is a point mass and the armature is'):
        replace(arm, armature=np.zeros(6))


def test_a_payload_must_be_a_body():
    arm = load_arm('ur5')
    with pytest.raises(ValueError, match='payload mass is -1'):
        with_payload(arm, -1.0)
    with pytest.raises(ValueError, match='payload inertia has principal moments'):
        with_payload(arm, 1.0, inertia=np.diag([1.0, 0.1, 0.1]))
    with pytest.raises(ValueError, match='tensor and no mass'):
        with_payload(arm, 0.0, inertia=np.eye(3))


def test_a_payload_makes_a_new_record_and_leaves_the_old_one():
    arm = load_arm('ur5')
    before = arm.constants.copy()
    loaded = with_payload(arm, 2.0, (0.0, 0.0, 0.1))
    assert loaded.payload.mass == 2.0
    assert not np.array_equal(loaded.constants, before)
    np.testing.assert_array_equal(arm.constants, before)
