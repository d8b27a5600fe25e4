"""Exercise: forces at the tool, in joints and back, and an observer of the momentum."""

from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.course.exercise import Exercise, Line, WrongAnswer, answer, checked, compare
from ur5_ros.course.kinematics import configurations
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.kinematics import jacobian
from ur5_ros.sim.plant import Plant

ARM = load_arm('ur5_real')
#: Gain of the observer [1/s].
OBSERVER_GAIN = 50.0


def _turn(wrench: np.ndarray) -> np.ndarray:
    return wrench * np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])


def _joint_torque(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs, wrenches = configurations(random), random.uniform(-20.0, 20.0, (5, 6))
    got = np.array([answer(module, 'joint_torque', q, wrench, shape=(6,))
                    for q, wrench in zip(qs, wrenches, strict=True)])
    J = jacobian(qs, ARM)
    right = np.einsum('nji,nj->ni', J, wrenches)
    return compare('J^T F [N m]', got, right, {
        'J instead of its transpose': np.einsum('nij,nj->ni', J, wrenches),
        "the force's sign: of the tool on its surroundings": -right,
        'base turned by pi (base_link, not base)': np.einsum('nji,nj->ni', J, _turn(wrenches)),
        'degrees instead of radians': np.einsum('nji,nj->ni', jacobian(np.deg2rad(qs), ARM),
                                                wrenches)}, 1e-5)


def _wrench(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs, wrenches = configurations(random), random.uniform(-20.0, 20.0, (5, 6))
    torques = np.einsum('nji,nj->ni', jacobian(qs, ARM), wrenches)
    got = np.array([answer(module, 'tool_wrench', q, torque, shape=(6,))
                    for q, torque in zip(qs, torques, strict=True)])
    return compare('the wrench [N, N m]', got, wrenches, {
        'the inverse of J instead of its transpose': np.linalg.solve(
            jacobian(qs, ARM), torques[..., None])[..., 0],
        "the force's sign: of the tool on its surroundings": -wrenches,
        'base turned by pi (base_link, not base)': _turn(wrenches)}, 1e-4)


def _observer(module: Any, random: np.random.Generator) -> tuple[str, str]:
    """A constant push on an arm of PyBullet that is held by springs."""
    if not isinstance(getattr(module, 'Observer', None), type):
        raise WrongAnswer('there is no class Observer')
    observer = module.Observer()
    middle = np.array([0.0, -1.4, 1.4, -1.5, -1.4, 0.2])
    force = random.uniform(3.0, 12.0, 3) * random.choice([-1.0, 1.0], 3)
    plant = Plant(ARM, {'initial_positions': middle.tolist()})
    stiffness = np.array([1500.0, 1500.0, 800.0, 200.0, 200.0, 100.0])
    try:
        plant.apply_wrench(force.tolist(), [0.0] * 3)
        for _ in range(800):
            state = plant.state
            got = checked('update', observer.update(
                state.stamp, *(part.copy() for part in state[1:])), (6,))
            g = dynamics_terms(state.q, state.qd, ARM)[2]
            plant.step(g - stiffness * (state.q - middle) - 0.1 * stiffness * state.qd)
    finally:
        plant.close()
    right = jacobian(state.q, ARM)[:3].T @ force
    g = dynamics_terms(state.q, state.qd, ARM)[2]
    return compare('the external torque [N m]', got, right, {
        "the force's sign: of the tool on its surroundings": -right,
        'no gravity': right - g, "gravity's sign": right - 2.0 * g}, 0.03)


EXERCISE = Exercise('contact', (
    Line('joint torque', 3.0, _joint_torque), Line('tool wrench', 3.0, _wrench),
    Line('observer', 4.0, _observer)))
