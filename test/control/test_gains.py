import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.control.gains import error_poles, gains_from, sampled_radius
from ur5_ros.errors import InputError

positive = st.floats(1e-3, 1e4)


def test_the_papers_gains_have_the_papers_poles():
    # s^2 + 10 s + 10 = 0: -5 +- sqrt(15), six times each
    poles = np.sort(error_poles(gains_from([10.0], [10.0])).real)
    assert_allclose(poles[:6], -5.0 - np.sqrt(15.0), rtol=1e-12)
    assert_allclose(poles[6:], -5.0 + np.sqrt(15.0), rtol=1e-12)


@given(st.lists(positive, min_size=6, max_size=6), st.lists(positive, min_size=6, max_size=6))
def test_any_positive_diagonal_gains_are_stable(kp, kd):
    gains = gains_from(kp, kd)
    assert error_poles(gains).real.max() < 0.0


@settings(max_examples=50)
@given(st.integers(0, 2**31), st.floats(-3.0, 3.0))
def test_any_symmetric_positive_definite_gains_are_stable(seed, decade):
    random = np.random.default_rng(seed)
    matrices = []
    for _ in range(2):
        root = random.normal(size=(6, 6))
        matrices.append((root @ root.T + 0.1 * np.eye(6)) * 10.0**decade)
    gains = gains_from(matrices[0].ravel(), matrices[1].ravel())
    assert_allclose(gains.kp, matrices[0])
    assert error_poles(gains).real.max() < 0.0


@pytest.mark.parametrize(('kp', 'kd', 'words'), [
    ([-10.0], [10.0], 'kp has the eigenvalue -10'),
    ([10.0], [0.0], 'kd has the eigenvalue 0'),
    ([10.0] * 5, [10.0], 'kp has 5 numbers'),
    ([np.nan], [10.0], 'kp holds nan'),
    ([10.0], [np.inf], 'kd holds inf'),
    ('stiff', [10.0], "kp is 'stiff'"),
    ((10.0 * np.eye(6) + np.eye(6, k=1)).ravel(), [10.0], 'differs from its transpose by 1'),
    ((np.eye(6) + 2.0 * (np.eye(6, k=1) + np.eye(6, k=-1))).ravel(), [10.0], 'eigenvalue'),
])
def test_gains_that_do_not_let_every_error_die_out_are_refused_with_the_number(kp, kd, words):
    with pytest.raises(InputError, match=words):
        gains_from(kp, kd)


def test_the_sampled_radius_shows_where_a_held_torque_begins_to_vibrate():
    # scalar, semi-implicit Euler: stable while 2 kd/h > kp + ... ; here 4 - 2 h kd - h^2 kp > 0
    period = 1e-3
    edge = (4.0 - period**2 * 10.0) / (2.0 * period)
    assert sampled_radius(gains_from([10.0], [0.999 * edge]), None, period) < 1.0
    assert sampled_radius(gains_from([10.0], [1.001 * edge]), None, period) > 1.0
