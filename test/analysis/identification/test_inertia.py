"""A physical arm is found for every fit, and is the fit's own where bodies can have it."""

import numpy as np
import pytest

from ur5_ros.analysis.identification.base_parameters import (
    all_parameters,
    base_of,
    typical_sizes,
)
from ur5_ros.analysis.identification.inertia import physical, pseudo_inertia, with_parameters
from ur5_ros.config import load_arm


@pytest.fixture(scope='module')
def base():
    return base_of(load_arm('ur5_real'))


def find(base, value, factor, arm):
    return physical(base.combination, value, factor, all_parameters(arm), typical_sizes(arm))


def eigenvalues(x):
    return np.array([np.linalg.eigvalsh(pseudo_inertia(body)) for body in x[:60].reshape(6, 10)])


def test_the_pseudo_inertia_of_points_is_the_sum_of_their_squares():
    # outside witness: the second moments of the points themselves (Wensing et al. 2018, eq. 5)
    points = np.random.default_rng(3).normal(size=(20, 3))
    mass = np.random.default_rng(4).uniform(0.1, 1.0, 20)
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in
                  zip(mass, points, strict=True))
    body = [mass.sum(), *(mass @ points), *inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    one = np.column_stack([points, np.ones(20)])
    np.testing.assert_allclose(pseudo_inertia(np.array(body)), (one.T * mass) @ one, atol=1e-12)


def test_what_a_fit_does_not_say_stays_as_it_was(base):
    arm = load_arm('ur5_real')
    found = find(base, np.zeros(len(base.columns)), np.zeros((1, len(base.columns))), arm)
    np.testing.assert_allclose(found, all_parameters(arm), rtol=1e-4, atol=1e-5)


def test_a_sharp_fit_of_a_real_body_is_met_exactly(base):
    start, true = load_arm('ur5_description'), load_arm('ur5_real')
    value = base.combination @ all_parameters(true)
    found = find(base, value, 1e8 * np.eye(len(value)), start)
    np.testing.assert_allclose(base.combination @ found, value, atol=1e-10)
    assert eigenvalues(found).min() > 0.0 and found[60:].min() >= 0.0


@pytest.mark.parametrize('seed', range(4))
def test_a_fit_that_no_body_has_still_gives_an_arm(base, seed):
    arm = load_arm('ur10e')
    value = base_of(arm).combination @ all_parameters(arm)
    spoiled = value + np.random.default_rng(seed).normal(0.0, 0.5, len(value))
    found = physical(base_of(arm).combination, spoiled, 1e3 * np.eye(len(value)),
                     all_parameters(arm), typical_sizes(arm))
    assert eigenvalues(found).min() > 0.0 and found[60:].min() >= 0.0
    made = with_parameters(arm, found, 'made')
    assert made.has_tensors and np.all(made.mass > 0.0)
    # and it is nearer to the fit than the arm that it began with
    before, after = (np.linalg.norm(base_of(arm).combination @ x - spoiled)
                     for x in (all_parameters(arm), found))
    assert after < before


def test_an_arm_of_point_masses_serves_as_a_beginning():
    arm = load_arm('ur5_controller')
    base = base_of(arm)
    value = base.combination @ all_parameters(arm)
    found = find(base, value, 1e4 * np.eye(len(value)), arm)
    assert eigenvalues(found).min() > 0.0
    np.testing.assert_allclose(base.combination @ found, value, atol=5e-3)
