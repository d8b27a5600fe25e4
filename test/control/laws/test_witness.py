"""Pinocchio's M, C and g, put into the equation of a law, give the torque of the law."""

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from witnesses import pinocchio_model

from ur5_ros.config import load_arm
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import gains_from
from ur5_ros.control.laws.registry import LAWS, make_law
from ur5_ros.signals import ArmState, Reference

REAL = load_arm('ur5_real')
START = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
KP, KD = np.array([90.0, 80.0, 70.0, 60.0, 50.0, 40.0]), np.array([8.0, 7.0, 6.0, 5.0, 4.0, 3.0])
LAYER = 0.05


def terms(state):
    """Return M, C and g of Pinocchio."""
    model = pinocchio_model(REAL)
    data, q = model.createData(), state.q + REAL.angle_offset
    upper = np.triu(pin.crba(model, data, q))
    return (upper + np.triu(upper, 1).T, pin.computeCoriolisMatrix(model, data, q, state.qd),
            pin.computeGeneralizedGravity(model, data, q))


def equations(state, reference):
    """Return the torque of each law as its equation says; an integral has not begun yet."""
    M, C, g = terms(state)
    e, rate = state.q - reference.q, state.qd - reference.qd
    spring = -KP * e - KD * rate
    bandwidth = KP / KD
    s, v, a = rate + bandwidth * e, reference.qd - bandwidth * e, reference.qdd - bandwidth * rate
    root = np.diag(np.sqrt(KD))
    weighed = M @ (reference.qdd + spring) + C @ state.qd + g
    passive = M @ a + C @ v + g - root @ M @ root @ s
    return {
        'pd': spring, 'pid': spring, 'gravity_pd': spring + g,
        'impedance': spring + g + M @ reference.qdd + C @ state.qd,
        'computed_torque': weighed, 'computed_torque_integral': weighed,
        'slotine_li': passive, 'adaptive': passive,
        'sliding_mode': M @ (a - KD * np.clip(s, -LAYER, LAYER)) + C @ state.qd + g}


@pytest.mark.parametrize('seed', range(3))
def test_pinocchio_gives_the_torque_of_every_law_in_joint_space(seed):
    q, qd, qr, qdr, qddr = np.random.default_rng(seed).uniform(-0.3, 0.3, (5, 6))
    state = ArmState(10_000_000, START + q, qd, np.zeros(6))
    reference = Reference(START + qr, qdr, 5.0 * qddr)
    expected = equations(state, reference)
    assert set(expected) == set(LAWS) - {'cartesian_impedance'}  # which has a test of its own
    for mode, torque in expected.items():
        parameters = ControlParameters.of({
            'mode': mode, 'kp': KP.tolist(), 'kd': KD.tolist(), 'ki': [10.0],
            'boundary_layer': [LAYER]})
        law = make_law(parameters, REAL, gains_from(parameters.kp, parameters.kd))
        parts, _ = law(state, state.q, reference, np.zeros(6), np.inf)
        assert_allclose(parts[0], torque, atol=1e-9, err_msg=mode)
