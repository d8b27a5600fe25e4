"""The body of one link, another arm with friction, and joints that stand still, as causes."""

from dataclasses import replace

import numpy as np
import pytest
from foreign_recordings import arm_messages, motion, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import with_payload

ARM = load_arm('ur5e')


@pytest.fixture
def judged(tmp_path):
    """Return a function that judges a motion, torques with noise, as one of an arm."""
    def judge(made, noise=0.0, arm='ur5e'):
        random = np.random.default_rng(3)
        noisy = made.with_(effort=made.effort + random.normal(0.0, noise, made.q.shape))
        folder = write_bag(tmp_path / 'bag', {'/joint_states': arm_messages(noisy)})
        return validate(load_run(folder, arm=arm))
    return judge


def with_link(field, i, value):
    """Return the arm with another value of a link."""
    changed = np.array(getattr(ARM, field))
    changed[i] = value
    return replace(ARM, **{field: changed})


@pytest.mark.parametrize('i, times, noise', [
    (1, 1.3, 0.0), (2, 0.7, 0.0), (2, 1.5, 0.0), (2, 0.7, 0.05), (2, 1.5, 0.05)])
def test_another_mass_of_a_link_is_named_with_its_size(judged, i, times, noise):
    plant = with_link('mass', i, times * ARM.mass[i])
    [cause] = judged(motion(plant), noise).causes
    assert cause['kind'] == 'link mass' and cause['links'][0] == i + 1
    [change] = cause['changes'][0]['change']
    assert change == pytest.approx((times - 1.0) * ARM.mass[i], abs=0.02 * ARM.mass[i])


@pytest.mark.parametrize('i', [1, 2])
def test_another_centre_of_mass_of_a_link_is_named_with_its_place(judged, i):
    moved = ARM.com[i] + np.array([0.03, -0.04, 0.05])
    [cause] = judged(motion(with_link('com', i, moved))).causes
    assert cause['kind'] == 'link centre of mass' and cause['links'] == [i + 1]
    np.testing.assert_allclose(cause['changes'][0]['change'], [0.03, -0.04, 0.05], atol=2e-3)


def test_a_load_that_looks_like_the_mass_of_a_link_says_so(judged):
    [cause] = judged(motion(with_link('mass', 4, 2.0 * ARM.mass[4])), 0.05).causes
    assert cause['kind'] == 'payload' or 5 in cause['links']
    assert 'the mass of link 5 (wrist 2) is' in cause['sentence']


def test_a_load_is_no_body_of_a_link(judged):
    made = motion(with_payload(ARM, 2.0, (0.05, -0.03, 0.08)))
    [cause] = judged(made, 0.05).causes
    assert cause['kind'] == 'payload' and cause['mass_kg'] == pytest.approx(2.0, abs=0.02)
    assert 'it would look the same' not in cause['sentence']


@pytest.mark.parametrize('noise', [0.0, 0.2])
def test_another_arm_is_named_although_its_joints_have_friction(judged, noise):
    made = motion('ur10e')
    friction = 6.0 * np.sign(made.qd) + 2.0 * made.qd
    result = judged(made.with_(effort=made.effort + friction), noise)
    kinds = [cause['kind'] for cause in result.causes]
    assert kinds[0] == 'wrong arm' and result.causes[0]['arm'].startswith('ur10e')
    assert set(kinds[1:]) <= {'Coulomb friction', 'viscous friction'} and len(kinds) > 1


def test_a_joint_that_stands_still_under_a_torque_is_named_and_no_cause_of_it(judged):
    made = motion()
    q, qd = made.q.copy(), made.qd.copy()
    q[:, 1], qd[:, 1] = -1.5, 0.0
    still = made.with_(q=q, qd=qd)
    qdd = np.gradient(qd, made.t, axis=0)
    effort = inverse_dynamics(q, qd, qdd, ARM)
    effort[:, 1] += 10.0 * np.sin(3.0 * made.t)  # held by friction at rest
    result = judged(still.with_(effort=effort), 0.02)
    assert [cause['kind'] for cause in result.causes] == ['unexplained']
    assert 'joints that stand still' in result.causes[0]['sentence']
    assert list(result.causes[0]['joints']) == ['shoulder_lift_joint']


def test_a_small_arm_judged_as_a_large_one_has_no_torque_factors(judged):
    made = motion('ur3')
    friction = 2.0 * np.sign(made.qd)
    kinds = [cause['kind'] for cause in judged(
        made.with_(effort=made.effort + friction), 0.05, arm='ur20').causes]
    assert kinds[0] in ('wrong arm', 'effort meaning') and 'torque factor' not in kinds
