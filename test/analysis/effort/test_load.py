"""An undeclared load at the tool hides neither what the effort is nor itself."""

import numpy as np
import pytest
from foreign_recordings import DRIVE, arm_messages, motion

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import with_payload

LOADED = {
    'gravity_excluded': lambda made, gravity: made.effort - gravity,
    'target': lambda made, gravity: gravity,
    'current': lambda made, gravity: made.effort / DRIVE,
    'other_sign': lambda made, gravity: -made.effort,
}


def loaded(mass, still=False):
    """Return the motion of an arm with a load, and the torque of gravity along it."""
    arm = with_payload(load_arm('ur5e'), mass, (0.0, 0.02, 0.06))
    made = motion(arm, still=still)
    return made, gravity_torque(made.q + arm.angle_offset, arm)


@pytest.mark.parametrize('mass', [1.0, 3.0])
@pytest.mark.parametrize('meaning', LOADED)
def test_an_undeclared_load_does_not_hide_what_the_effort_is(judged, meaning, mass):
    made, gravity_of_it = loaded(mass)
    result = judged(arm_messages(made.with_(effort=LOADED[meaning](made, gravity_of_it))))
    sentence = result.check('effort').sentence
    assert f'--effort {meaning}' in sentence and f'a load of {mass:g} kg' in sentence
    assert [cause['kind'] for cause in result.causes] == ['effort meaning']


@pytest.mark.parametrize('meaning', ['gravity_excluded', 'target', 'other_sign'])
def test_with_the_option_the_load_is_the_cause(judged, meaning):
    made, gravity_of_it = loaded(2.0)
    result = judged(arm_messages(made.with_(effort=LOADED[meaning](made, gravity_of_it))),
                    effort=meaning)
    assert [cause['kind'] for cause in result.causes] == ['payload']
    assert result.causes[0]['mass_kg'] == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize('noise', [0.0, 0.3])
def test_at_rest_the_load_that_explains_the_torque_is_named_without_its_place(judged, noise):
    made, _ = loaded(1.5, still=True)
    random = np.random.default_rng(5)
    result = judged(arm_messages(made.with_(
        effort=made.effort + random.normal(0.0, noise, (700, 6)),
        q=made.q + random.normal(0.0, 1e-4 * noise, (700, 6)),
        qd=random.normal(0.0, 3e-3 * noise, (700, 6)))))
    assert [cause['kind'] for cause in result.causes] == ['payload']
    assert result.causes[0]['mass_kg'] == pytest.approx(1.5, rel=0.02)
    assert 'does not determine its centre of mass' in result.causes[0]['sentence']


@pytest.mark.parametrize('noise', [0.0, 0.1])
def test_at_rest_a_torque_that_no_load_explains_is_not_attributed(judged, noise):
    made = motion(still=True)
    random = np.random.default_rng(6)
    result = judged(arm_messages(made.with_(
        effort=made.effort + np.array([0.0, -5.0, -2.0, 0.3, 0.0, 0.0])
        + random.normal(0.0, noise, (700, 6)))))
    assert result.verdict == 'fail'
    assert [cause['kind'] for cause in result.causes] == ['unexplained']
    assert 'this motion does not show more' in result.causes[0]['sentence']
