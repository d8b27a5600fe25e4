"""The plant's scheme: Pinocchio, which had no part in it, finds every torque accounted for."""

import numpy as np
import pytest

from ur5_ros.sim.payload import loaded_arm

RNG = np.random.default_rng(21)
STIRRING = 10.0  # rad/s^2
#: A joint slower than this stands: rounding leaves 1e-13 rad/s on the lightest wrist.
STANDSTILL = 1e-9

IMPERFECT = {
    'nothing': {},
    'viscous friction': {'friction__viscous': [10.0, 10.0, 8.0, 2.0, 2.0, 1.0]},
    'Coulomb friction': {'friction__coulomb': [8.0, 8.0, 5.0, 1.0, 1.0, 0.4]},
    'payload': {'payload__mass': 3.0, 'payload__com': [0.03, -0.02, 0.08]},
    'tilted gravity': {'gravity': [3.0, -2.0, -8.0]},
    'everything': {'friction__viscous': [10.0, 10.0, 8.0, 2.0, 2.0, 1.0],
                   'friction__coulomb': [8.0, 8.0, 5.0, 1.0, 1.0, 0.4],
                   'payload__mass': 3.0, 'payload__com': [0.03, -0.02, 0.08],
                   'gravity': [3.0, -2.0, -8.0]},
}


def torque_to_hold(plant, witness):
    q, qd = plant.truth.q, plant.truth.qd
    return witness.bias(q, qd) - 5.0 * (witness.mass_matrix(q) @ qd)


@pytest.mark.parametrize('name', ['ur5', 'ur5_real', 'ur10e'])
@pytest.mark.parametrize('imperfections', IMPERFECT.values(), ids=IMPERFECT.keys())
@pytest.mark.parametrize('pushed', [False, True], ids=['free', 'pushed'])
def test_no_torque_is_unaccounted_for(plant_of, witness_of, name, imperfections, pushed):
    plant = plant_of(arm=name, physics_rate=1000, **imperfections)
    given = plant.parameters.by_name()
    witness = witness_of(loaded_arm(plant.arm, given['payload.mass'], given['payload.com']))
    if given['gravity']:
        witness.set_gravity(given['gravity'])
    wrench = np.zeros(6)
    if pushed:
        wrench = np.array([20.0, -10.0, 15.0, 1.0, -2.0, 0.5])
        plant.apply_wrench(wrench[:3], wrench[3:])
    viscous, coulomb = (np.array(given[f'friction.{kind}']) for kind in ('viscous', 'coulomb'))
    worst, stood, moved = 0.0, 0, 0
    for step in range(400):
        q, qd = plant.truth.q, plant.truth.qd
        external = witness.jacobian(q).T @ wrench
        command = torque_to_hold(plant, witness) - external
        if step > 100:
            command += witness.mass_matrix(q) @ (STIRRING * np.sin(0.02 * step + np.arange(6)))
            command += 2.0 * coulomb * np.sin(0.05 * step + np.arange(6))
        after = plant.step(command)
        applied = after.effort
        np.testing.assert_allclose(after.q, q + 1e-3 * after.qd, rtol=0.0, atol=1e-14)
        friction = (external + applied - witness.bias(q, qd) - viscous * after.qd
                    - witness.mass_matrix(q) @ (after.qd - qd) / 1e-3)
        still = (np.abs(after.qd) < STANDSTILL) & (coulomb > 0.0)
        stood, moved = stood + still.sum(), moved + (~still).sum()
        beyond = np.where(still, np.maximum(np.abs(friction) - coulomb, 0.0),
                          friction - coulomb * np.sign(after.qd))
        worst = max(worst, np.abs(beyond).max())
    assert worst < 1e-9
    assert moved > 100
    assert stood > 100 or not coulomb.any()


def test_substeps_are_steps_of_the_scheme_under_one_torque(plant_of, witness_of):
    plant = plant_of(arm='ur5_real', control_rate=125, physics_rate=1000,
                     friction__viscous=[5.0] * 6)
    witness = witness_of(plant.arm)
    q, qd = plant.truth.q.copy(), plant.truth.qd.copy()
    for _ in range(50):
        stirring = witness.mass_matrix(q) @ (STIRRING * RNG.uniform(-1.0, 1.0, 6))
        command = torque_to_hold(plant, witness) + stirring
        state = plant.step(command)
        for _ in range(8):
            A = witness.mass_matrix(q) / 1e-3 + np.diag([5.0] * 6)
            qd = np.linalg.solve(A, witness.mass_matrix(q) @ qd / 1e-3 - witness.bias(q, qd)
                                 + state.effort)
            q = q + 1e-3 * qd
        np.testing.assert_allclose(state.q, q, rtol=0.0, atol=1e-11)
        np.testing.assert_allclose(state.qd, qd, rtol=0.0, atol=1e-10)


def test_engine_and_witness_agree_on_inertia_bias_and_jacobian(plant_of, witness_of, every_arm):
    arm = loaded_arm(every_arm, 2.0, [0.05, 0.02, 0.1])
    plant = plant_of(arm=every_arm.name, payload__mass=2.0, payload__com=[0.05, 0.02, 0.1])
    bullet, witness = plant.mechanics.bullet, witness_of(arm)
    witness.model.armature = np.zeros(6)
    for _ in range(50):
        q, qd = RNG.uniform(-3.0, 3.0, 6), RNG.uniform(-3.0, 3.0, 6)
        M, h = witness.mass_matrix(q), witness.bias(q, qd)
        np.testing.assert_allclose(bullet.mass_matrix(q.tolist()), M, atol=1e-13 * np.abs(M).max())
        np.testing.assert_allclose(bullet.bias(q.tolist(), qd.tolist()), h,
                                   atol=1e-12 * np.abs(h).max())
        J = witness.jacobian(q)
        np.testing.assert_allclose(bullet.jacobian(q.tolist()), J, atol=1e-13)
        point = np.array([0.3, -0.2, 0.1])
        lever = np.diag([-1.0, -1.0, 1.0]) @ witness.frames(q)['tool0'][:3, :3] @ point
        J[:3] += np.cross(J[3:].T, lever).T
        np.testing.assert_allclose(bullet.jacobian(q.tolist(), point.tolist()), J, atol=1e-13)


def test_friction_far_beyond_the_stable_range_of_an_explicit_torque_is_stable(plant_of):
    # Explicit viscous friction blows up on the wrists of ur5 (1e-4 kg m^2) from 0.2 N m s/rad at
    # 1 kHz; Coulomb friction of 0.4 N m would chatter at 2 rad/s.
    plant = plant_of(arm='ur5', friction__viscous=[15.0] * 3 + [5.0] * 3,
                     friction__coulomb=[0.4] * 6, initial_velocities=[1.0, -1, 1, -2, 2, -3])
    signs = np.sign(plant.truth.qd)
    moving = np.ones(6, dtype=bool)
    plant.change('gravity', [0.0, 0.0, 0.0])
    for _ in range(300):
        qd = plant.step(np.zeros(6)).qd
        assert np.abs(qd).max() < 3.0
        moving &= signs * qd > STANDSTILL
    assert not moving[3:].any(), 'friction has brought the wrists to rest'
    assert np.abs(plant.truth.qd[3:]).max() < STANDSTILL


def test_coulomb_friction_holds_the_arm_up_if_it_is_strong_enough(plant_of):
    plant = plant_of(arm='ur5', friction__coulomb=[0.0, 80.0, 40.0, 10.0, 10.0, 1.0])
    start = plant.truth.q
    for _ in range(2000):
        state = plant.step(np.zeros(6))
    assert np.abs(state.q - start).max() < 1e-9
