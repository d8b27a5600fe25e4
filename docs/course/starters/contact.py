"""Forces at the tool: fill in the functions."""

import numpy as np

from ur5_ros import load_arm

ARM = load_arm('ur5_real')  # jacobian, dynamics_terms of ur5_ros take it
GAIN = 50.0                 # of the observer, 1/s


def joint_torque(q, wrench):
    """Return what force and torque on the tool [N, N m], in base, are on the joints [N m]."""
    return np.zeros(6)


def tool_wrench(q, torque):
    """Return the force and torque on the tool that are such a torque on the joints."""
    return np.zeros(6)


class Observer:
    """Estimates the external torque on the joints from the momentum M qd."""

    def update(self, stamp, q, qd, effort):
        """Return the estimate [N m]; effort is the torque that acted since the state before."""
        return np.zeros(6)
