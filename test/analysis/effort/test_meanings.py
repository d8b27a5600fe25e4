"""An effort that is no joint torque is named, and judged by the meaning that is stated."""

import numpy as np
import pytest
from foreign_recordings import DRIVE, arm_messages, gravity, motion

from ur5_ros.errors import InputError

MEANINGS = {
    'gravity_excluded': lambda made: made.effort - gravity(made),
    'target': gravity,
    'current': lambda made: made.effort / DRIVE,
    'other_sign': lambda made: -made.effort,
}


@pytest.mark.parametrize('friction', [0.0, 1.0])
@pytest.mark.parametrize('meaning', MEANINGS)
def test_an_effort_that_is_no_joint_torque_is_named_with_the_option(judged, made, meaning,
                                                                    friction):
    changed = MEANINGS[meaning](made) + friction * 0.02 * np.sign(made.qd)
    result = judged(arm_messages(made.with_(effort=changed)))
    assert result.verdict == 'fail'
    assert f'--effort {meaning}' in result.check('effort').sentence
    assert [cause['kind'] for cause in result.causes] == ['effort meaning']


@pytest.mark.parametrize('meaning', MEANINGS)
def test_with_the_option_the_verdict_is_judged_by_the_meaning(judged, made, meaning):
    result = judged(arm_messages(made.with_(effort=MEANINGS[meaning](made))), effort=meaning)
    assert result.verdict == 'pass', [c.sentence for c in result.checks if c.verdict == 'fail']
    assert result.check('inverse dynamics').verdict == 'pass'


@pytest.mark.parametrize('meaning', MEANINGS)
def test_a_stated_meaning_that_is_wrong_fails(judged, made, meaning):
    if meaning != 'current':  # a factor a joint fits joint torque as well
        assert judged(arm_messages(made), effort=meaning).verdict == 'fail'


def test_a_constant_effort_is_no_measurement(judged, made):
    result = judged(arm_messages(made.with_(effort=np.tile(made.effort[0], (700, 1)))))
    assert result.verdict == 'fail' and 'constant' in result.check('effort').sentence


def test_friction_does_not_make_another_meaning(judged):
    result = judged(arm_messages(motion(friction=3.0)))
    assert result.check('effort').verdict == 'pass'


def test_a_meaning_that_does_not_exist_is_refused(judged, made):
    with pytest.raises(InputError, match='give one of: total'):
        judged(arm_messages(made), effort='newton')
