"""Exercise: inertia matrix, Coriolis matrix and gravity torque."""

from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.course.exercise import Exercise, Line, answer, compare
from ur5_ros.course.kinematics import configurations
from ur5_ros.model.dynamics import coriolis_matrix, gravity_torque, inertia_matrix

ARM = load_arm('ur5')
_DEGREES = 'degrees instead of radians'


def _gravity(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs = configurations(random)
    got = np.array([answer(module, 'gravity_torque', q, shape=(6,)) for q in qs])
    right = gravity_torque(qs, ARM)
    return compare('g [N m]', got, right, {
        "gravity's sign": -right, _DEGREES: gravity_torque(np.deg2rad(qs), ARM)}, 1e-5)


def _inertia(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs = configurations(random)
    got = np.array([answer(module, 'inertia_matrix', q, shape=(6, 6)) for q in qs])
    return compare('M [kg m^2]', got, inertia_matrix(qs, ARM), {
        _DEGREES: inertia_matrix(np.deg2rad(qs), ARM)}, 1e-5)


def _coriolis(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs, qds = configurations(random), random.uniform(-1.0, 1.0, (5, 6))
    got = np.array([answer(module, 'coriolis_matrix', q, qd, shape=(6, 6))
                    for q, qd in zip(qs, qds, strict=True)])
    right = coriolis_matrix(qs, qds, ARM)
    product = np.einsum('nij,nj->ni', got, qds)
    mistakes = {'Christoffel symbols without the half': 2.0 * right,
                'transposed': np.swapaxes(right, 1, 2),
                _DEGREES: coriolis_matrix(np.deg2rad(qs), qds, ARM)}
    if np.allclose(product, np.einsum('nij,nj->ni', right, qds), atol=1e-5):
        mistakes["C qd is right, but M' - 2 C is not skew: not the Christoffel matrix"] = got
    return compare('C [N m s/rad]', got, right, mistakes, 1e-5)


EXERCISE = Exercise('dynamics', (
    Line('gravity', 3.0, _gravity), Line('inertia', 3.0, _inertia),
    Line('Coriolis', 4.0, _coriolis)))
