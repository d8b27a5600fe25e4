"""A law that does not know its plant: stable, and wrong by exactly what the formula says."""

import numpy as np
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.config.parameters import SIM_PARAMETERS, complete
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix
from ur5_ros.model.parameters import with_payload
from ur5_ros.sim.plant import plant_from_parameters

HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
COULOMB = np.array([1.0, 1.0, 0.6, 0.1, 0.1, 0.05])
UNKNOWN = {
    'arm': 'ur5_real', 'payload.mass': 1.0, 'payload.com': [0.0, 0.0, 0.05],
    'friction.viscous': [2.0, 2.0, 1.5, 0.3, 0.3, 0.2],
    'delay.command_periods': 2, 'initial_positions': HOME.tolist(),  # 2 ms at 1 kHz
}
ARM = load_arm('ur5_real')
LOADED = with_payload(ARM, 1.0, (0.0, 0.0, 0.05))


def settle(seconds, plant_parameters, **law):
    """Hold the arm at HOME; return its last state and fastest joint of the last second."""
    controller = controller_from_parameters({'arm': 'ur5_real', **law}, 1000)
    plant = plant_from_parameters(plant_parameters)
    try:
        speeds = []
        for _ in range(round(seconds * 1000)):
            state = plant.state
            speeds.append(np.abs(state.qd).max())
            plant.step(controller.update(state).torque.total)
    finally:
        plant.close()
    return state.q, max(speeds[-1000:])


def unknown_gravity(q):
    """Return what the law does not know [N m]: g_law(q) - g_plant(q)."""
    return gravity_torque(q, ARM) - gravity_torque(q, LOADED)


def test_the_steady_error_is_what_the_mismatch_formula_predicts():
    # facts sheet 6.2 at rest: e = M^-1 (g_law - g_plant) / 10; viscous friction and delay vanish
    q, speed = settle(15.0, UNKNOWN)
    assert speed < 1e-5
    predicted = np.linalg.solve(inertia_matrix(q, ARM), unknown_gravity(q)) / 10.0
    assert np.abs(predicted).max() > 0.1  # a kilogram is worth it
    assert_allclose(q - HOME, predicted, rtol=0.01, atol=1e-4)


def test_dry_friction_keeps_the_arm_within_its_band_about_the_prediction():
    q, speed = settle(15.0, UNKNOWN | {'friction.coulomb': COULOMB.tolist()})
    assert speed < 1e-4
    unbalanced = unknown_gravity(q) - inertia_matrix(q, ARM) @ (10.0 * (q - HOME))
    assert np.all(np.abs(unbalanced) <= COULOMB * 1.001)


def test_ten_times_the_stiffness_leaves_a_tenth_of_the_error():
    q, _ = settle(6.0, UNKNOWN, kp=[100.0], kd=[20.0])
    predicted = np.linalg.solve(inertia_matrix(q, ARM), unknown_gravity(q)) / 100.0
    assert_allclose(q - HOME, predicted, rtol=0.01, atol=1e-5)


def test_on_the_papers_profile_it_stays_stable():
    controller = controller_from_parameters(
        {'arm': 'ur5_real', 'experiment': 'kebria_fig11', 'autostart': True}, 1000)
    plant = plant_from_parameters(complete(
        SIM_PARAMETERS, UNKNOWN | {'friction.coulomb': COULOMB.tolist()}))
    try:
        errors = []
        for _ in range(20_000):
            state = plant.state
            answer = controller.update(state)
            errors.append(np.abs(state.q - answer.reference.q).max())
            plant.step(answer.torque.total)
    finally:
        plant.close()
    assert max(errors) < 0.6
    assert answer.status == 'moving'
    assert not plant.stopped
