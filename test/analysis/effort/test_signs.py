"""An effort with the other sign, at all joints or at some, is named and turned."""

import numpy as np
import pytest
from foreign_recordings import STATES, arm_messages, gravity, remarks, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate

TURNED = np.array([1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
ALL = -np.ones(6)


def test_joints_with_the_other_sign_are_named(judged, made):
    result = judged(arm_messages(made.with_(effort=TURNED * made.effort)))
    assert 'with the other sign at shoulder_lift_joint, wrist_3_joint' in (
        result.check('effort').sentence)


def test_the_option_turns_the_joints_that_are_turned(judged, made):
    result = judged(arm_messages(made.with_(effort=TURNED * made.effort)), effort='other_sign')
    assert result.verdict == 'pass'


def test_friction_with_the_other_sign_is_no_other_meaning(judged, made):
    turned = -(made.effort + 3.0 * np.sign(made.qd))
    result = judged(arm_messages(made.with_(effort=turned)))
    assert '--effort other_sign' in result.check('effort').sentence


@pytest.mark.parametrize('friction', [0.0, 3.0])
@pytest.mark.parametrize('sign, at', [
    (ALL, ''), (TURNED, ' at shoulder_lift_joint, wrist_3_joint')])
@pytest.mark.parametrize('meaning', ['gravity_excluded', 'target'])
def test_an_effort_without_motion_or_gravity_and_with_the_other_sign_is_named(
        judged, made, meaning, sign, at, friction):
    own = gravity(made) if meaning == 'target' else (
        made.effort - gravity(made) + friction * np.sign(made.qd))
    messages = arm_messages(made.with_(effort=sign * own))
    sentence = judged(messages).check('effort').sentence
    if meaning == 'target':
        at = at.replace(', wrist_3_joint', '')  # whose gravity is none
    assert f'with the other sign{at} (' in sentence and f'--effort {meaning}' in sentence


@pytest.mark.parametrize('sign, at', [
    (ALL, 'sign: it'), (TURNED, 'sign at shoulder_lift_joint, wrist_3_joint: it')])
@pytest.mark.parametrize('meaning', ['gravity_excluded', 'target'])
def test_with_the_option_an_effort_of_the_other_sign_passes_and_says_so(
        judged, tmp_path, made, meaning, sign, at):
    own = gravity(made) if meaning == 'target' else made.effort - gravity(made)
    if meaning == 'target':
        at = at.replace(', wrist_3_joint', '')
    folder = write_bag(tmp_path / 'turned', {STATES: arm_messages(made.with_(effort=sign * own))})
    run = load_run(folder, arm='ur5e', effort=meaning)
    assert validate(run).verdict == 'pass'
    assert any(f'the effort has the other {at} was turned' in each for each in run.remarks)


@pytest.mark.parametrize('meaning', ['gravity_excluded', 'target'])
@pytest.mark.parametrize('friction', [0.0, 5.0])
def test_friction_does_not_turn_the_sign_of_an_effort(judged, made, meaning, friction):
    own = gravity(made) if meaning == 'target' else made.effort - gravity(made)
    messages = arm_messages(made.with_(effort=own + friction * np.sign(made.qd)))
    assert 'the other sign' not in remarks(judged(messages, effort=meaning))
