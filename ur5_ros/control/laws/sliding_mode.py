"""Sliding mode with a boundary layer: a bounded push against a bounded disturbance."""

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import model_terms, torque_of
from ur5_ros.control.laws.slotine_li import SlidingLaw, sliding_variable
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque


class SlidingMode(SlidingLaw):
    r"""
    :math:`\tau = M (a - K_D \Phi\,\mathrm{sat}(s / \Phi)) + C \dot q + g`.

    Slotine and Li 1991, section 7.2, with :math:`s = \dot e + \Lambda e`,
    :math:`\Lambda = K_D^{-1} K_P`: a push of KD Phi towards s = 0, linear within
    :math:`|s| < \Phi`, so that it does not chatter.

    """

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._layer = np.broadcast_to(np.array(parameters.boundary_layer), (6,))

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque."""
        s, _, a = sliding_variable(state, reference, self._bandwidth)
        M, C, g = model_terms(state, self.arm)
        inertial = M @ reference.qdd
        push = self.gains.kd @ np.clip(s, -self._layer, self._layer)
        return torque_of(inertial, M @ (a - push) - inertial, C @ state.qd, g)
