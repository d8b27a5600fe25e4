"""Where no arm is given, the known arms that fit the effort are named."""

import pytest
from foreign_recordings import DRIVE, arm_messages

from ur5_ros.errors import InputError


def test_without_an_arm_one_line_says_so_and_which_known_arms_fit(judged, made):
    with pytest.raises(InputError, match=r'no arm is known; give one: --arm NAME; of the known '
                       r'arms these fit the torques best: ur5e \(9.\d+e-06 N m RMS') as caught:
        judged(arm_messages(made), arm=None)
    assert '\n' not in str(caught.value)


def test_an_arm_that_cannot_be_is_called_so(judged, made):
    result = judged(arm_messages(made), arm='ur5')
    assert result.verdict == 'fail'
    assert result.causes[0]['kind'] == 'wrong arm' and result.causes[0]['arm'] == 'ur5e'


def test_without_an_arm_and_torque_the_arms_that_fit_another_meaning_are_named(judged, made):
    with pytest.raises(InputError, match=r'none of the known arms fits .*ur5e \(.*--effort curre'):
        judged(arm_messages(made.with_(effort=made.effort / DRIVE)), arm=None)
