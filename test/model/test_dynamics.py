"""Laws of the dynamics, witnessed by numbers of other programs and by other programs."""

import json
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import (
    dynamics_terms,
    forward_dynamics,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
)
from ur5_ros.model.kinematics import forward_kinematics

REFERENCE = Path(__file__).parents[3] / 'shared' / 'facts' / 'dynamics_reference.json'


@pytest.mark.skipif(not REFERENCE.exists(), reason=f'no {REFERENCE}')
def test_kebria_arm_equals_the_reference_states():
    arm = load_arm('ur5_kebria2016')
    for state in json.loads(REFERENCE.read_text())['sets']['A_paper_intended']['states']:
        q, qd, qdd, tau = (np.array(state[name]) for name in ('q', 'qd', 'qdd', 'tau'))
        m, c, g = dynamics_terms(q, qd, arm)
        np.testing.assert_allclose(m, state['M'], atol=1e-14)
        np.testing.assert_allclose(c, state['C_christoffel'], atol=1e-14)
        np.testing.assert_allclose(g, state['g'], atol=1e-13)
        np.testing.assert_allclose(inertia_matrix(q, arm), state['M'], atol=1e-14)
        np.testing.assert_allclose(gravity_torque(q, arm), state['g'], atol=1e-13)
        np.testing.assert_allclose(inverse_dynamics(q, qd, qdd, arm), tau, atol=1e-13)
        np.testing.assert_allclose(forward_dynamics(q, qd, tau, arm), qdd, atol=1e-10)
        np.testing.assert_allclose(forward_kinematics(q, arm), state['T06'], atol=1e-14)
