"""Each family of friction is found where it acts, and no other where it does not."""

import numpy as np
import pytest

from ur5_ros.analysis.identification.friction.families import (
    FEATURES,
    choose_family,
    folds_of,
    friction_features,
)

N = 1200
BLOCK = np.arange(N) // 20


def sliding(seed=0):
    """Return speed, load and features of a joint that swings with changing size."""
    random = np.random.default_rng(seed)
    t = np.arange(N) * 0.075
    speed = np.sin(0.9 * t) * (0.6 + 0.5 * np.sin(0.11 * t)) + 0.02 * random.normal(size=N)
    load = 20.0 * np.sin(0.37 * t + 1.0)
    features = friction_features(*(np.tile(x[:, None], (1, 6))
                                   for x in (speed, np.sign(speed), load)))
    return speed, load, features[:, 0]


def found(torque, features, noise=0.3, seed=1):
    y = torque + np.random.default_rng(seed).normal(0.0, noise, N)
    return choose_family(features, np.zeros((N, 0)), y, folds_of(BLOCK))


@pytest.mark.parametrize('more, name', [
    (lambda v, load: 0.0 * v, 'viscous and Coulomb'),
    (lambda v, load: 1.0 + 0.0 * v, 'viscous and Coulomb, asymmetric'),
    (lambda v, load: -1.5 * v**3, 'viscous and Coulomb, viscous cubic'),
    (lambda v, load: 0.1 * np.abs(load) * np.sign(v), 'viscous and Coulomb, load-dependent'),
    (lambda v, load: 4.0 * np.sign(v) * np.exp(-(v / 0.1)**2),
     'viscous and Coulomb, Stribeck 0.1 rad/s')])
def test_the_family_that_acts_is_chosen(more, name):
    speed, load, features = sliding()
    family = found(3.0 * speed + 2.0 * np.sign(speed) + more(speed, load), features)
    assert family.name == name
    assert family.held_out == pytest.approx(0.3, rel=0.1)
    assert family.held_out <= family.held_out_linear < family.held_out_none


def test_noise_without_motion_has_no_friction():
    _, _, features = sliding()
    family = found(np.zeros(N), features)
    assert family.name == 'none' and family.features == ()


def test_what_is_held_out_is_not_fitted():
    # a feature that explains the first part alone does not help to predict the others
    speed, _, features = sliding()
    torque = 3.0 * speed + 2.0 * np.sign(speed)
    torque[:200] += 5.0 * speed[:200]**3
    family = found(torque, features)
    assert family.held_out > 0.3
    assert len(FEATURES) == features.shape[1]
