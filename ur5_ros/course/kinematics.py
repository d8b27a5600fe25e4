"""Exercise: kinematics of the UR5, with the errata of the paper's equations."""

from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.course.exercise import Exercise, Line, answer, compare
from ur5_ros.model.inverse_kinematics import inverse_kinematics
from ur5_ros.model.kinematics import forward_kinematics, jacobian

ARM = load_arm('ur5')
_HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])


def configurations(random: np.random.Generator, count: int = 5) -> np.ndarray:
    """Return configurations away from singularities [rad], shape (count, 6)."""
    q = random.uniform(-np.pi, np.pi, (count, 6))
    q[:, 2] = random.uniform(0.4, 2.4, count) * random.choice([-1.0, 1.0], count)
    q[:, 4] = random.uniform(0.4, 2.4, count) * random.choice([-1.0, 1.0], count)
    return q


def craig_pose(q: np.ndarray) -> np.ndarray:
    """Return the pose that Table I gives when it is read as modified (Craig's) parameters."""
    pose = np.eye(4)
    for angle, a, d, alpha in zip(q, ARM.a, ARM.d, ARM.alpha, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        pose = pose @ np.array([[c, -s, 0.0, a], [s * ca, c * ca, -sa, -sa * d],
                                [s * sa, c * sa, ca, ca * d], [0.0, 0.0, 0.0, 1.0]])
    return pose


def printed_pose(q: np.ndarray) -> np.ndarray:
    """Return the pose with the position of the paper's eq. (2), which lacks s5 beside d6."""
    pose, deficit = forward_kinematics(q, ARM), 1.0 - np.sin(q[4])
    q234 = q[1] + q[2] + q[3]
    along = np.array([np.cos(q[0]) * np.cos(q234), np.sin(q[0]) * np.cos(q234)])
    pose[:2, 3] -= ARM.d[5] * along * deficit
    return pose


def _pose(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs = configurations(random)
    got = np.array([answer(module, 'forward_kinematics', q, shape=(4, 4)) for q in qs])
    right = forward_kinematics(qs, ARM)
    return compare('the pose [1, m]', got, right, {
        'degrees instead of radians': forward_kinematics(np.deg2rad(qs), ARM),
        'base turned by pi (base_link, not base)': _HALF_TURN @ right,
        "Craig's (modified) DH parameters for standard ones": np.array(
            [craig_pose(q) for q in qs]),
        'eq. (2) as printed, without s5 beside d6': np.array([printed_pose(q) for q in qs]),
    })


def _jacobian(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs = configurations(random)
    got = np.array([answer(module, 'jacobian', q, shape=(6, 6)) for q in qs])
    right = jacobian(qs, ARM)
    swapped = np.concatenate([right[:, 3:], right[:, :3]], axis=1)
    turned = np.kron(np.eye(2), _HALF_TURN[:3, :3]) @ right
    return compare('the Jacobian [m, 1]', got, right, {
        'degrees instead of radians': jacobian(np.deg2rad(qs), ARM),
        'base turned by pi (base_link, not base)': turned,
        'angular rows before linear ones': swapped,
    })


def _inverse(module: Any, random: np.random.Generator) -> tuple[str, str]:
    near = configurations(random) + random.choice([-1.0, 1.0], (5, 6)) * np.pi
    poses = forward_kinematics(near, ARM)
    start = near + random.uniform(-0.01, 0.01, (5, 6))
    got = np.array([answer(module, 'inverse_kinematics', pose, q, shape=(6,))
                    for pose, q in zip(poses, start, strict=True)])
    mistakes = {}
    if np.allclose(forward_kinematics(got, ARM), poses, atol=1e-5):
        turns = np.round((got - near) / (2.0 * np.pi))
        one_turn = np.ptp(got) <= 2.0 * np.pi < np.ptp(near)
        only_turns = np.allclose(got - 2.0 * np.pi * turns, near, atol=1e-5)
        mistakes = {'missing +-2 pi: not the turn nearest to q_near' if one_turn or only_turns
                    else 'another branch than the one nearest to q_near': got}
    elif np.allclose(forward_kinematics(np.deg2rad(got), ARM), poses, atol=1e-5):
        mistakes = {'degrees instead of radians': got}
    return compare('q [rad]', got, near, mistakes, 1e-5)


def _branches(module: Any, random: np.random.Generator) -> tuple[str, str]:
    qs = configurations(random, 8)
    poses = forward_kinematics(qs, ARM)
    right = np.array([float(len(inverse_kinematics(pose, ARM).q)) for pose in poses])
    got = np.array([answer(module, 'number_of_solutions', pose, shape=()) for pose in poses])
    return compare('the number of solutions', got, right, {
        'one solution alone': np.ones(8), 'all eight, reachable or not': np.full(8, 8.0)}
        if (right != 8.0).any() else {'one solution alone': np.ones(8)})


EXERCISE = Exercise('kinematics', (
    Line('pose', 4.0, _pose), Line('Jacobian', 3.0, _jacobian),
    Line('inverse', 2.0, _inverse), Line('number of solutions', 1.0, _branches)))
