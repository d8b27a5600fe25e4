"""An effort in another unit, such as a motor current, is named by its factors."""

import numpy as np
import pytest
from foreign_recordings import DRIVE, arm_messages

UNITS = {
    'motor current in mA': lambda effort: 1000.0 * effort / DRIVE,
    'motor current with the other sign': lambda effort: -effort / DRIVE,
    'joint torque in another unit': lambda effort: 1000.0 * effort,
    # per cent of the largest torque, as drives report it
    'joint torque in another unit (joints 1 to 6: 1.5, 1.5, 1.5': lambda effort: effort / np.array(
        [1.5, 1.5, 1.5, 0.28, 0.28, 0.28]),
}


@pytest.mark.parametrize('looks', UNITS)
def test_an_effort_in_another_unit_is_named_and_judged_by_the_option(judged, made, looks):
    changed = arm_messages(made.with_(effort=UNITS[looks](made.effort)))
    result = judged(changed)
    assert f'looks like {looks}' in result.check('effort').sentence
    assert [cause['kind'] for cause in result.causes] == ['effort meaning']


@pytest.mark.parametrize('looks', UNITS)
def test_with_the_option_another_unit_passes(judged, made, looks):
    result = judged(arm_messages(made.with_(effort=UNITS[looks](made.effort))), effort='current')
    assert result.check('inverse dynamics').verdict == 'pass'


def test_a_current_in_steps_of_a_tenth_of_an_ampere_is_a_current(judged, made):
    result = judged(arm_messages(made.with_(effort=np.round(made.effort / DRIVE, 1))))
    assert '--effort current' in result.check('effort').sentence
