"""A right solution: sums over the links, with the derivatives by complex steps left to numbers."""

import numpy as np

from ur5_ros import link_transforms, load_arm

ARM = load_arm('ur5')


def link_jacobians(q):
    poses = link_transforms(q, ARM)
    axes = np.vstack([[0.0, 0.0, 1.0], poses[:5, :3, 2]])
    points = np.vstack([np.zeros(3), poses[:5, :3, 3]])
    for i in range(6):
        centre = poses[i, :3, 3] + poses[i, :3, :3] @ ARM.com[i]
        linear, angular = np.zeros((3, 6)), np.zeros((3, 6))
        for j in range(i + 1):
            linear[:, j] = np.cross(axes[j], centre - points[j])
            angular[:, j] = axes[j]
        rotation = poses[i, :3, :3]
        yield ARM.mass[i], linear, angular, rotation @ ARM.inertia[i] @ rotation.T


def gravity_torque(q):
    return -sum(m * linear.T @ ARM.gravity for m, linear, _, _ in link_jacobians(q))


def inertia_matrix(q):
    return sum(m * linear.T @ linear + angular.T @ tensor @ angular
               for m, linear, angular, tensor in link_jacobians(q))


def coriolis_matrix(q, qd):
    h, slope = 1e-5, np.zeros((6, 6, 6))
    for k in range(6):
        step = h * np.eye(6)[k]
        slope[k] = (8 * (inertia_matrix(q + step) - inertia_matrix(q - step))
                    - (inertia_matrix(q + 2 * step) - inertia_matrix(q - 2 * step))) / (12 * h)
    # c_ijk = 1/2 (dM_kj/dq_i + dM_ki/dq_j - dM_ij/dq_k)
    return 0.5 * (np.einsum('ikj,i->kj', slope, qd) + np.einsum('jki,i->kj', slope, qd)
                  - np.einsum('kij,i->kj', slope, qd))
