"""The dynamics are linear in the inertial parameters, and 36 combinations of them matter."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import with_payload
from ur5_ros.model.regressor import (
    base_parameters,
    dynamics_regressor,
    inertial_parameters,
)


def states(count, seed):
    return np.random.default_rng(seed).uniform(-3.0, 3.0, (3, count, 6))


def test_regressor_times_parameters_is_the_torque_of_the_kernels(arm):
    arm = with_payload(replace(arm, gravity=np.array([1.0, 2.0, -9.0])), 2.0, (0.1, 0.0, 0.1))
    q, qd, qdd = states(300, 1)
    tau = dynamics_regressor(q, qd, qdd, arm) @ inertial_parameters(arm) + arm.armature * qdd
    np.testing.assert_allclose(tau, inverse_dynamics(q, qd, qdd, arm), atol=1e-10)


def test_pinocchio_has_the_same_regressor(pinocchio_model):
    import pinocchio as pin
    arm = load_arm('ur10e')
    model = pinocchio_model(arm)
    data = model.createData()
    # Pinocchio's body frames turn with the joint, ours lie at the far end of the link
    change = np.zeros((60, 60))
    for i in range(6):
        c, s = np.cos(arm.alpha[i]), np.sin(arm.alpha[i])
        link = pin.SE3(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
                       np.array([arm.a[i], 0, arm.d[i]]))
        for j in range(10):
            unit = np.zeros(10)
            unit[j] = 1.0
            moved = _moved(unit, link)
            change[10 * i:10 * i + 10, 10 * i + j] = moved
    q, qd, qdd = states(50, 2)
    ours = dynamics_regressor(q, qd, qdd, arm)
    for i in range(50):
        theirs = pin.computeJointTorqueRegressor(model, data, q[i], qd[i], qdd[i])
        np.testing.assert_allclose(ours[i], theirs @ change, atol=1e-10)


def _moved(p, link):
    """Return the ten parameters of a body about another frame, by its pseudo inertia."""
    tensor = np.array([[p[4], p[5], p[7]], [p[5], p[6], p[8]], [p[7], p[8], p[9]]])
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    pseudo[:3, 3] = pseudo[3, :3] = p[1:4]
    pseudo[3, 3] = p[0]
    pseudo = link.homogeneous @ pseudo @ link.homogeneous.T
    second = pseudo[:3, :3]
    tensor = np.trace(second) * np.eye(3) - second
    return np.array([pseudo[3, 3], *pseudo[:3, 3], *tensor[[0, 0, 1, 0, 1, 2],
                                                           [0, 1, 1, 2, 2, 2]]])


def test_36_base_parameters_carry_the_whole_torque(arm):
    base = base_parameters(arm)
    assert base.combination.shape == (36, 60)
    q, qd, qdd = states(200, 3)
    y = dynamics_regressor(q, qd, qdd, arm)
    pi = inertial_parameters(arm)
    np.testing.assert_allclose(y[..., base.columns] @ (base.combination @ pi), y @ pi, atol=1e-9)
    assert np.linalg.matrix_rank(y.reshape(-1, 60), tol=1e-8) == 36
    assert base.condition < 100.0


def test_base_parameters_are_found_again_from_motion_and_torque():
    arm = load_arm('ur5_real')
    base = base_parameters(arm)
    q, qd, qdd = states(500, 4)
    y = dynamics_regressor(q, qd, qdd, arm)[..., base.columns].reshape(-1, 36)
    rotors = np.zeros((500, 6, 6))
    rotors[:, np.arange(6), np.arange(6)] = qdd
    tau = inverse_dynamics(q, qd, qdd, arm).reshape(-1)
    # the rotors of joints 1 and 2 cannot be told from Iyy of link 1 and Izz of link 2
    pi = inertial_parameters(arm)
    pi[[6, 19]] += arm.armature[:2]
    columns = np.hstack([y, rotors.reshape(-1, 6)[:, 2:]])
    found, *_ = np.linalg.lstsq(columns, tau, rcond=None)
    np.testing.assert_allclose(found, [*(base.combination @ pi), *arm.armature[2:]], atol=1e-9)


def test_tilted_gravity_makes_two_more_parameters_visible():
    arm = replace(load_arm('ur5'), gravity=np.array([3.0, 0.0, -9.0]))
    assert base_parameters(arm).columns.size == 38


def test_bad_arguments_are_named():
    arm = load_arm('ur5')
    with pytest.raises(ValueError, match=r'qdd has shape \(5,\)'):
        dynamics_regressor(np.zeros(6), np.zeros(6), np.zeros(5), arm)
