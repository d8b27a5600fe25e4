"""Sine, cosine and arctangent of the kernels against 40 digits."""

import mpmath
import numpy as np
import pytest
from numba import njit

from ur5_ros.model.kernels import trigonometry

EPS = np.finfo(float).eps
ANGLES = np.concatenate([
    np.linspace(-7.0, 7.0, 1001), np.pi / 4 * np.arange(-40, 41), [0.0, 1e-300, -1e-9, 1e-5],
    np.random.default_rng(1).uniform(-1000.0, 1000.0, 500)])


@njit
def sine_cosine(angle):
    return trigonometry.sine_cosine(angle)


@njit
def arctangent(y, x):
    return trigonometry.arctangent(y, x)


def test_sine_and_cosine_are_good_to_the_last_digits():
    with mpmath.workdps(40):
        for x in ANGLES:
            s, c = sine_cosine(x)
            assert abs(s - mpmath.sin(x)) <= EPS * abs(mpmath.sin(x)) + EPS ** 2
            assert abs(c - mpmath.cos(x)) <= EPS * abs(mpmath.cos(x)) + EPS ** 2


@pytest.mark.parametrize('x', [1e6, -3.3e7, 1e9])
def test_of_large_angles_no_more_is_lost_than_their_own_rounding(x):
    s, c = sine_cosine(x)
    with mpmath.workdps(40):
        assert abs(s - mpmath.sin(x)) < abs(x) * EPS
        assert abs(c - mpmath.cos(x)) < abs(x) * EPS


@pytest.mark.parametrize('x', [np.nan, np.inf, -np.inf, 1e17, -1e200])
def test_what_is_no_angle_has_no_sine(x):
    assert np.isnan(sine_cosine(x)).all()


def test_arctangent_is_good_to_the_last_digits():
    radii = np.array([1.0, 1e-12, 3e8])
    with mpmath.workdps(40):
        for angle in np.concatenate([ANGLES[:1001:3], np.pi / 8 * np.arange(-8, 9)]):
            for r in radii:
                y, x = r * np.sin(angle), r * np.cos(angle)
                exact = mpmath.atan2(y, x)
                assert abs(arctangent(y, x) - exact) <= 1.5 * EPS * abs(exact) + EPS ** 2


def test_arctangent_on_the_axes():
    for y, x in ((0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-0.0, -1.0), (1.0, 0.0), (-1.0, 0.0)):
        assert arctangent(y, x) == np.arctan2(y, x)
