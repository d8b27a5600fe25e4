"""Exercise: Coulomb and viscous friction, as a torque and from measurements."""

from typing import Any

import numpy as np

from ur5_ros.course.exercise import Exercise, Line, answer, compare


def _law(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return random.uniform(2.0, 15.0, 6), random.uniform(1.0, 8.0, 6)


def friction(qd: np.ndarray, viscous: np.ndarray, coulomb: np.ndarray) -> np.ndarray:
    """Return the torque that the motors need against friction [N m]."""
    return viscous * qd + coulomb * np.sign(qd)


def _torque(module: Any, random: np.random.Generator) -> tuple[str, str]:
    viscous, coulomb = _law(random)
    speeds = random.uniform(-2.0, 2.0, (5, 6))
    speeds[0, 0] = 0.0
    got = np.array([answer(module, 'friction_torque', qd, viscous, coulomb, shape=(6,))
                    for qd in speeds])
    right = np.array([friction(qd, viscous, coulomb) for qd in speeds])
    at_rest = right.copy()
    at_rest[0, 0] = coulomb[0]
    return compare('the friction torque [N m]', got, right, {
        "friction's sign": -right,
        'Coulomb friction acts at rest': at_rest,
        'Coulomb friction does not change its sign': viscous * speeds + coulomb,
        'degrees instead of radians': friction(np.rad2deg(speeds), viscous, coulomb)})


def _fit(module: Any, random: np.random.Generator) -> tuple[str, str]:
    viscous, coulomb = _law(random)
    speeds = random.uniform(0.05, 2.0, (400, 6)) * random.choice([-1.0, 1.0], (400, 6))
    torques = friction(speeds, viscous, coulomb) + random.normal(0.0, 0.05, (400, 6))
    got = answer(module, 'fit_friction', speeds, torques, shape=(2, 6))
    rows = []
    for joint in range(6):
        qd = speeds[:, joint]
        rows.append(np.linalg.lstsq(np.stack([qd, np.sign(qd)], axis=1), torques[:, joint],
                                    rcond=None)[0])
    right = np.array(rows).T
    return compare('viscous and Coulomb friction', got, right, {
        'Coulomb before viscous': right[::-1], "friction's sign": -right,
        'degrees instead of radians': right * np.array([[np.pi / 180.0], [1.0]])}, 1e-3)


def _power(module: Any, random: np.random.Generator) -> tuple[str, str]:
    viscous, coulomb = _law(random)
    speeds = random.uniform(-2.0, 2.0, (20, 6))
    power = np.array([answer(module, 'friction_torque', qd, viscous, coulomb, shape=(6,)) @ qd
                      for qd in speeds])
    if (power >= 0.0).all():
        return '', ''
    return (f'friction gives {-power.min():.3g} W to the motors; it only takes',
            "friction's sign" if (power <= 0.0).all() else '')


EXERCISE = Exercise('friction', (
    Line('torque', 4.0, _torque), Line('fit', 4.0, _fit), Line('power', 2.0, _power)))
