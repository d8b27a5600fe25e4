"""Laws of the dynamics, and other programs as witnesses, on every arm."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import (
    coriolis_matrix,
    dynamics_terms,
    forward_dynamics,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
)
from ur5_ros.model.energy import kinetic_energy, potential_energy
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.model.parameters import with_payload

REFERENCE = Path(__file__).parents[1] / 'data' / 'dynamics_reference.json'
COUNT = 1000


def states(count, seed, columns=3):
    rng = np.random.default_rng(seed)
    scale = (np.pi, 3.0, 10.0)
    return [rng.uniform(-scale[i], scale[i], (count, 6)) for i in range(columns)]


def relative(ours, theirs):
    """Return the worst difference of any item, relative to the largest number of that item."""
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    axes = tuple(range(1, ours.ndim))
    return (np.abs(ours - theirs).max(axis=axes) / np.abs(theirs).max(axis=axes)).max()


def test_the_arm_of_the_paper_equals_the_reference_states():
    arm = load_arm('ur5_kebria2016')
    for state in json.loads(REFERENCE.read_text())['states']:
        q, qd, qdd, tau = (np.array(state[name]) for name in ('q', 'qd', 'qdd', 'tau'))
        m, c, g = dynamics_terms(q, qd, arm)
        np.testing.assert_allclose(m, state['M'], atol=1e-14)
        np.testing.assert_allclose(c, state['C_christoffel'], atol=1e-14)
        np.testing.assert_allclose(g, state['g'], atol=1e-13)
        np.testing.assert_allclose(c @ qd, state['Cqd'], atol=1e-13)
        np.testing.assert_allclose(inverse_dynamics(q, qd, qdd, arm), tau, atol=1e-13)
        np.testing.assert_allclose(forward_dynamics(q, qd, tau, arm), qdd, atol=1e-10)
        np.testing.assert_allclose(forward_kinematics(q, arm), state['T06'], atol=1e-14)


def test_pinocchio_finds_the_same_dynamics(arm, pinocchio_model):
    import pinocchio as pin
    model = pinocchio_model(arm)
    data = model.createData()
    q, qd, qdd = states(COUNT, 1)
    m, c, g = dynamics_terms(q, qd, arm)
    tau = inverse_dynamics(q, qd, qdd, arm)
    acceleration = forward_dynamics(q, qd, tau, arm)
    theirs = [[], [], [], [], []]
    for a, b, d, t in zip(q, qd, qdd, tau, strict=True):
        upper = np.triu(pin.crba(model, data, a))
        theirs[0].append(upper + np.triu(upper, 1).T)
        theirs[1].append(pin.computeCoriolisMatrix(model, data, a, b).copy())
        theirs[2].append(pin.computeGeneralizedGravity(model, data, a).copy())
        theirs[3].append(pin.rnea(model, data, a, b, d).copy())
        theirs[4].append(pin.aba(model, data, a, b, t).copy())
    for ours, his in zip((m, c, g, tau, acceleration), theirs, strict=True):
        assert relative(ours, his) < 1e-10
    np.testing.assert_array_equal(inertia_matrix(q, arm), m)
    assert relative(gravity_torque(q, arm), theirs[2]) < 1e-10
    assert relative(coriolis_matrix(q, qd, arm), theirs[1]) < 1e-10


def test_pybullet_finds_the_same_mass_matrix_and_torque(simulated_arm, bullet_body):
    import pybullet as bullet
    client, body = bullet_body(simulated_arm)
    q, qd, qdd = states(COUNT, 2)
    rotors = np.diag(simulated_arm.armature)  # PyBullet has none
    m = inertia_matrix(q, simulated_arm) - rotors
    tau = inverse_dynamics(q, qd, qdd, simulated_arm) - qdd @ rotors
    masses = [bullet.calculateMassMatrix(body, list(a), physicsClientId=client) for a in q]
    torques = [bullet.calculateInverseDynamics(body, list(a), list(b), list(c),
                                               physicsClientId=client)
               for a, b, c in zip(q, qd, qdd, strict=True)]
    assert relative(m, masses) < 1e-10
    assert relative(tau, torques) < 1e-10


def test_mujoco_finds_the_same_dynamics(simulated_arm, mujoco_model):
    import mujoco
    model = mujoco_model(simulated_arm)
    data = mujoco.MjData(model)
    q, qd, qdd = states(COUNT, 3)
    tau = inverse_dynamics(q, qd, qdd, simulated_arm)
    m, c, g = dynamics_terms(q, qd, simulated_arm)
    masses, biases, accelerations = [], [], []
    for a, b, t in zip(q, qd, tau, strict=True):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = a, b, t
        mujoco.mj_forward(model, data)
        column = np.empty(6)
        masses.append(np.empty((6, 6)))
        for j, unit in enumerate(np.eye(6)):
            mujoco.mj_mulM(model, data, column, unit)
            masses[-1][:, j] = column
        biases.append(data.qfrc_bias.copy())
        accelerations.append(data.qacc.copy())
    assert relative(m, masses) < 1e-10
    assert relative(np.einsum('nij,nj->ni', c, qd) + g, biases) < 1e-10
    assert relative(forward_dynamics(q, qd, tau, simulated_arm), accelerations) < 1e-10
    assert relative(accelerations, qdd) < 1e-9


def test_m_dot_minus_two_c_is_skew(arm):
    q, qd = states(200, 4, 2)
    c = coriolis_matrix(q, qd, arm)

    def slope(h):
        return (inertia_matrix(q + h * qd, arm) - inertia_matrix(q - h * qd, arm)) / (2.0 * h)

    m_dot = (4.0 * slope(5e-4) - slope(1e-3)) / 3.0
    scale = np.abs(m_dot).max()
    np.testing.assert_allclose(m_dot, c + np.swapaxes(c, -1, -2), atol=1e-9 * scale)


def test_c_is_the_christoffel_matrix_of_m(arm):
    q, qd = states(20, 5, 2)
    h = 1e-3

    def slope(h):
        steps = h * np.eye(6)
        return (inertia_matrix(q[:, None] + steps, arm)
                - inertia_matrix(q[:, None] - steps, arm)) / (2.0 * h)

    dm = (4.0 * slope(h / 2) - slope(h)) / 3.0  # dm[n, k, i, j]: dM_ij / dq_k
    christoffel = 0.5 * (np.einsum('nkij,nk->nij', dm, qd) + np.einsum('njik,nk->nij', dm, qd)
                         - np.einsum('nijk,nk->nij', dm, qd))
    np.testing.assert_allclose(coriolis_matrix(q, qd, arm), christoffel,
                               atol=1e-9 * np.abs(christoffel).max())


def test_gravity_torque_is_the_slope_of_the_potential_energy(arm):
    tilted = replace(arm, gravity=np.array([3.0, -4.0, -8.0]))
    q, = states(100, 6, 1)
    h = 1e-3

    def slope(h):
        steps = h * np.eye(6)
        return (potential_energy(q[:, None] + steps, tilted)
                - potential_energy(q[:, None] - steps, tilted)) / (2.0 * h)

    np.testing.assert_allclose(gravity_torque(q, tilted), (4.0 * slope(h / 2) - slope(h)) / 3.0,
                               atol=1e-8)


def test_gravity_may_point_anywhere(pinocchio_model):
    import pinocchio as pin
    arm = replace(load_arm('ur10e'), gravity=np.array([5.0, -6.0, 7.0]))
    model = pinocchio_model(arm)
    data = model.createData()
    q, qd, qdd = states(100, 7)
    for a, b, c in zip(q, qd, qdd, strict=True):
        np.testing.assert_allclose(gravity_torque(a, arm),
                                   pin.computeGeneralizedGravity(model, data, a), atol=1e-11)
        np.testing.assert_allclose(inverse_dynamics(a, b, c, arm),
                                   pin.rnea(model, data, a, b, c), atol=1e-10)
        np.testing.assert_allclose(dynamics_terms(a, b, arm)[2], gravity_torque(a, arm),
                                   atol=1e-12)


def test_payload_is_a_body_fixed_to_the_flange(pinocchio_model):
    import pinocchio as pin
    bare = load_arm('ur5_real')
    com, tensor = np.array([0.02, -0.05, 0.12]), np.diag([0.03, 0.02, 0.04])
    loaded = with_payload(bare, 3.0, com, tensor)
    model = pinocchio_model(bare)
    place = pin.SE3(np.eye(3), np.array([0.0, 0.0, bare.d[5]]))
    model.appendBodyToJoint(6, pin.Inertia(3.0, com, tensor), place)
    data = model.createData()
    q, qd, qdd = states(100, 8)
    ours = inverse_dynamics(q, qd, qdd, loaded)
    theirs = [pin.rnea(model, data, a, b, c).copy()
              for a, b, c in zip(q, qd, qdd, strict=True)]
    assert relative(ours, theirs) < 1e-12
    weight = with_payload(bare, 3.0)  # a point in the flange: gravity by virtual work
    lift = jacobian(q, bare)[:, 2, :] * 3.0 * -bare.gravity[2]
    np.testing.assert_allclose(gravity_torque(q, weight) - gravity_torque(q, bare), lift,
                               atol=1e-12)


def test_armature_is_on_the_diagonal_of_m_only():
    real, bare = load_arm('ur5_real'), load_arm('ur5')
    q, qd = states(50, 9, 2)
    m, c, g = dynamics_terms(q, qd, replace(real, gravity=bare.gravity))
    m0, c0, g0 = dynamics_terms(q, qd, bare)
    np.testing.assert_allclose(m - m0, np.broadcast_to(np.diag(real.armature), m.shape),
                               atol=1e-14)
    np.testing.assert_allclose(c, c0, atol=1e-14)
    np.testing.assert_allclose(g, g0, atol=1e-13)


def test_forward_dynamics_undoes_inverse_dynamics_at_kinematic_singularities(arm):
    q, qd, qdd = states(100, 10)
    q[:40, 4], q[30:70, 2], q[60:, 3] = 0.0, np.pi, -q[60:, 1] - q[60:, 2]
    tau = inverse_dynamics(q, qd, qdd, arm)
    assert relative(forward_dynamics(q, qd, tau, arm), qdd) < 1e-9


def test_m_is_positive_definite_also_with_point_masses_and_rotors(arm):
    q, = states(500, 11, 1)
    assert np.linalg.eigvalsh(inertia_matrix(q, arm)).min() > 0.0


def test_a_free_arm_keeps_its_energy():
    arm = load_arm('ur5_real')
    x = np.concatenate(states(1, 12, 2), axis=1)[0]

    def rate(x):
        return np.concatenate([x[6:], forward_dynamics(x[:6], x[6:], np.zeros(6), arm)])

    def energy(x):
        return kinetic_energy(x[:6], x[6:], arm) + potential_energy(x[:6], arm)

    start, h = energy(x), 1e-3
    for _ in range(2000):
        k1 = rate(x)
        k2 = rate(x + 0.5 * h * k1)
        k3 = rate(x + 0.5 * h * k2)
        x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(x + h * k3))
    assert abs(energy(x) - start) < 1e-7 * abs(start)


def test_kebria_arm_moves_like_the_same_arm_in_the_manufacturers_angles():
    paper = load_arm('ur5_kebria2016')
    ur5 = load_arm('ur5')
    same = replace(ur5, d=paper.d)
    q, qd, qdd = states(200, 13)
    np.testing.assert_allclose(inverse_dynamics(q + paper.angle_offset, qd, qdd, paper),
                               inverse_dynamics(q, qd, qdd, same), atol=1e-11)


def test_closed_form_gravity_of_the_paper_arm():
    arm = load_arm('ur5_kebria2016')
    q, = states(100, 14, 1)
    s = np.sin
    q23, q234 = q[:, 1] + q[:, 2], q[:, 1] + q[:, 2] + q[:, 3]
    k2, k3, ks, kx = 37.929335, 16.181961, 1.4789627, -0.3449672  # lever arms times weights
    g4 = ks * s(q234) + kx * np.cos(q234) * s(q[:, 4])
    g3 = k3 * np.cos(q23) + g4
    g2 = k2 * np.cos(q[:, 1]) + g3
    g5 = kx * s(q234) * np.cos(q[:, 4])
    zero = np.zeros(100)
    np.testing.assert_allclose(gravity_torque(q, arm), np.stack([zero, g2, g3, g4, g5, zero], 1),
                               atol=2e-6)
