"""A right solution."""

import numpy as np

from ur5_ros import dynamics_terms, jacobian, load_arm

ARM = load_arm('ur5_real')
GAIN = 50.0


def joint_torque(q, wrench):
    return jacobian(q, ARM).T @ wrench


def tool_wrench(q, torque):
    return np.linalg.solve(jacobian(q, ARM).T, torque)


class Observer:
    def __init__(self):
        self.before, self.estimate = None, np.zeros(6)

    def update(self, stamp, q, qd, effort):
        M, C, g = dynamics_terms(q, qd, ARM)
        if self.before is not None:
            last, momentum = self.before
            dt = (stamp - last) * 1e-9
            external = (M @ qd - momentum) / dt - effort - C.T @ qd + g
            self.estimate = self.estimate + GAIN * dt * (external - self.estimate)
        self.before = stamp, M @ qd
        return self.estimate
