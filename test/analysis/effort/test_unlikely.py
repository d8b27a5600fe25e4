"""Efforts of other joints, and efforts that are no measurement, are named so."""

import numpy as np
import pytest
from foreign_recordings import arm_messages

from ur5_ros.signals import JOINT_NAMES

EXCHANGED = {'exchanged: shoulder_pan_joint, elbow_joint': [2, 1, 0, 3, 4, 5],
             'exchanged: shoulder_lift_joint, elbow_joint': [0, 2, 1, 3, 4, 5],
             'in the other order': [5, 4, 3, 2, 1, 0]}


@pytest.mark.parametrize('fields', [('effort',), ('q', 'qd', 'effort')])
@pytest.mark.parametrize('how', EXCHANGED)
def test_values_of_other_joints_are_named_so(judged, made, how, fields):
    order = EXCHANGED[how]
    result = judged(arm_messages(made.with_(**{
        field: getattr(made, field)[:, order] for field in fields})))
    sentence = result.check('effort').sentence
    assert how in sentence and 'name the joints in the order of their values' in sentence
    assert sentence.startswith('the efforts' if len(fields) == 1 else 'the positions, velocities')
    assert [cause['kind'] for cause in result.causes] == ['effort meaning']


@pytest.mark.parametrize('joint, value', [(2, 5.0), (3, 0.0)])
def test_a_joint_whose_effort_never_changes_is_named(judged, made, joint, value):
    effort = made.effort.copy()
    effort[:, joint] = value
    result = judged(arm_messages(made.with_(effort=effort)))
    assert f'the effort of {JOINT_NAMES[joint]} is constant' in result.check('effort').sentence
    assert result.verdict == 'fail'


@pytest.mark.parametrize('about', [0.0, 2.0])
def test_noise_in_place_of_a_torque_is_no_measurement(judged, made, about):
    noise = np.random.default_rng(7).normal(about, 0.05, (700, 6))
    result = judged(arm_messages(made.with_(effort=noise)))
    assert result.check('effort').sentence.startswith('the effort is constant, not a measurement')
    assert [cause['kind'] for cause in result.causes] == ['effort meaning']
