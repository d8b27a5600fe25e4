"""The friction of a real UR5e: its own calibration, reproduced by a sweep of constant speeds."""

import numpy as np

#: Motor torque [N m] of a UR5e's joint calibration at the joint speeds below, joints 1 to 6
#: (INTO-CPS-Association/aurt,
#: resources/Dataset/ur5e_data/robot_calibration_summary.txt).
SPEEDS = (-3.2, -1.5, -0.5, -0.01, 0.01, 0.5, 1.5, 3.2)
MOTOR_TORQUE = np.array([
    [-0.181, -0.139, -0.094, -0.059, 0.055, 0.095, 0.136, 0.174],
    [-0.219, -0.158, -0.106, -0.066, 0.064, 0.107, 0.160, 0.210],
    [-0.180, -0.136, -0.089, -0.050, 0.050, 0.089, 0.136, 0.183],
    [-0.044, -0.034, -0.024, -0.014, 0.014, 0.023, 0.033, 0.043],
    [-0.038, -0.030, -0.021, -0.012, 0.012, 0.020, 0.029, 0.037],
    [-0.040, -0.031, -0.022, -0.012, 0.013, 0.022, 0.028, 0.039]])
#: From the back-EMF of the same table: 23.8 V at 3.2 rad/s and 0.072 V s/rad.
GEAR_RATIO = 101.0


def friction_at(plant, witness, speed):
    """Return the torque that keeps every joint at a speed, beside the inverse dynamics [N m]."""
    held = np.zeros(6)
    for step in range(5000):
        q, qd = plant.truth.q, plant.truth.qd
        slower, inertia = speed - qd, witness.mass_matrix(q)
        held += 2.5 * np.diag(inertia) * slower
        after = plant.step(inertia @ (100.0 * slower) + witness.bias(q, qd) + held)
        if step > 100 and np.abs(after.qd - speed).max() < 1e-3 * abs(speed):
            return after.effort - witness.bias(q, qd) - inertia @ (after.qd - qd) / 1e-3
    raise AssertionError(f'{speed} rad/s was not reached')


def test_a_sweep_of_constant_speeds_gives_the_calibration_curve_of_a_real_joint(
        plant_of, witness_of):
    plant = plant_of(arm='ur5e_real', friction__from_arm=True, gravity=[0.0, 0.0, 0.0])
    witness = witness_of(plant.arm)
    witness.set_gravity([0.0, 0.0, 0.0])
    measured = np.array([friction_at(plant, witness, speed) for speed in SPEEDS]).T
    error = measured / (GEAR_RATIO * MOTOR_TORQUE) - 1.0
    print(f'worst of 48 points of the calibration: {np.abs(error).max():.2%}')
    assert np.abs(error).max() < 0.05
