"""The physical inertial parameters nearest to a fit."""

from dataclasses import replace

import numpy as np

from ur5_ros.model.parameters import ArmParameters, Payload

#: Smallest eigenvalue of a pseudo-inertia matrix, tolerance, and largest number of iterations.
FLOOR, TOLERANCE, MAX_ITERATIONS = 1e-6, 1e-12, 5000


def physical(combination: np.ndarray, fitted: np.ndarray, start: np.ndarray) -> np.ndarray:
    """
    Return the physical parameters nearest to a fit, shape (66,); on it where those are.

    Alternating projections between the fit, combination @ x = fitted, and the bodies whose
    pseudo-inertia matrices are positive definite (Wensing, Kim, Slotine 2018, IEEE RA-L 3(1),
    eq. 8), from ``start`` on, shape (66,): ten inertial parameters a link, then six rotor
    inertias. ``combination``, shape (b, 66), makes the b fitted base parameters of them.

    """
    q, r = np.linalg.qr(combination.T)
    target = np.linalg.solve(r.T, fitted)
    x = start
    for _ in range(MAX_ITERATIONS):
        x = x - q @ (q.T @ x - target)
        bodies = nearest_bodies(x)
        if np.abs(bodies - x).max() <= TOLERANCE:
            break
        x = bodies
    return x


def with_parameters(arm: ArmParameters, x: np.ndarray, name: str) -> ArmParameters:
    """Return the arm with other bodies and rotors: ten parameters a link, then six rotors."""
    links = x[:60].reshape(6, 10)
    mass = links[:, 0].copy()
    com = links[:, 1:4] / mass[:, None]
    tensor = np.empty((6, 3, 3))
    for i, (m, c) in enumerate(zip(mass, com, strict=True)):
        xx, xy, yy, xz, yz, zz = links[i, 4:]
        about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        tensor[i] = about_origin - m * (np.dot(c, c) * np.eye(3) - np.outer(c, c))
        tensor[i] = 0.5 * (tensor[i] + tensor[i].T)
    return replace(arm, name=name, mass=mass, com=com, inertia=tensor,
                   armature=np.maximum(x[60:], 0.0), payload=Payload())


def nearest_bodies(x: np.ndarray) -> np.ndarray:
    """Return the nearest parameters with positive definite pseudo-inertias and rotors."""
    out = x.copy()
    for i in range(6):
        m, hx, hy, hz, xx, xy, yy, xz, yz, zz = x[10 * i:10 * i + 10]
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        pseudo = np.empty((4, 4))
        pseudo[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
        pseudo[:3, 3] = pseudo[3, :3] = hx, hy, hz
        pseudo[3, 3] = m
        value, vector = np.linalg.eigh(pseudo)
        if value[0] >= FLOOR:
            continue
        pseudo = (vector * np.maximum(value, FLOOR)) @ vector.T
        second = pseudo[:3, :3]
        inertia = np.trace(second) * np.eye(3) - second
        out[10 * i:10 * i + 10] = [pseudo[3, 3], *pseudo[:3, 3], *inertia[
            [0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    out[60:] = np.maximum(x[60:], 0.0)
    return out
