"""Friction of the joints: it sticks, it breaks away where it should, and no torque is lost."""

import numpy as np
import pytest

from ur5_ros.config import SIM_PARAMETERS, complete, load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.friction import JointFriction, friction_terms, friction_torque
from ur5_ros.sim.payload import loaded_arm
from ur5_ros.sim.plant import plant_from_parameters

RNG = np.random.default_rng(19)

PARTS = {
    'friction__viscous': [9.0, 10.0, 9.0, 2.4, 2.1, 2.2],
    'friction__coulomb': [5.0, 6.0, 4.0, 1.3, 1.2, 1.2],
    'friction__static': [7.0, 8.0, 5.0, 1.6, 1.5, 1.4],
    'friction__stribeck_velocity': [0.1] * 6,
    'friction__load_factor': [0.05] * 6,
    'friction__viscous_quadratic': [-2.0] * 3 + [-0.5] * 3,
    'friction__viscous_cubic': [0.4] * 3 + [0.1] * 3,
    'friction__temperature_factor': [0.9] * 6,
    'friction__asymmetry': [0.1, -0.1, 0.05, 0.0, 0.02, -0.02],
}


def friction_of(parts):
    return JointFriction(**{name.removeprefix('friction__'): np.array(value)
                            for name, value in parts.items()})


def breakaway(plant, direction):
    """Return the torque beside gravity at which each joint at rest begins to move [N m]."""
    gravity = gravity_torque(plant.truth.q + plant.arm.angle_offset, plant.arm)
    _, level, offset = friction_terms(friction_of(PARTS), np.zeros(6), gravity)
    return gravity, direction * level + offset


def test_a_joint_does_not_creep_in_a_minute_under_half_its_breakaway_torque(plant_of):
    plant = plant_of(arm='ur5_real', **PARTS)
    start = plant.truth.q
    gravity, least = breakaway(plant, 1.0)
    for _ in range(60_000):
        state = plant.step(gravity + 0.5 * least)
    assert np.abs(state.q - start).max() < 1e-9
    print(f'creep in a minute: {np.abs(state.q - start).max():.2g} rad')


@pytest.mark.parametrize('direction', [1.0, -1.0], ids=['forwards', 'backwards'])
@pytest.mark.parametrize('joint', range(6))
def test_a_joint_at_rest_moves_from_static_friction_and_its_share_of_the_load_on(
        plant_of, joint, direction):
    plant = plant_of(arm='ur5_real', stop_after=0.0, **PARTS)
    gravity, least = breakaway(plant, direction)
    start = plant.truth.q
    for share, moves in ((0.99, False), (1.01, True)):
        plant.reset()
        command = gravity.copy()
        command[joint] += share * least[joint]
        for _ in range(10_000):
            state = plant.step(command)
            if abs(state.q[joint] - start[joint]) > 1e-3:
                break
        moved = abs(state.q[joint] - start[joint])
        assert moved > 1e-3 if moves else moved < 1e-9


def witnessed_torque(plant, witness, friction, wrench, before, after):
    """Return what Pinocchio and the law of friction leave unaccounted of one step [N m]."""
    q, qd = before.q, before.qd
    bias, external = witness.bias(q, qd), witness.jacobian(q).T @ wrench
    damping, level, offset = friction_terms(friction, qd, bias - external)
    dry = (external + after.effort - bias - damping * after.qd
           - witness.mass_matrix(q) @ (after.qd - qd) / 1e-3 - offset)
    still = np.abs(after.qd) < 1e-9
    sliding = dry - level * np.sign(after.qd)
    return np.where(still, np.maximum(np.abs(dry) - level, 0.0), sliding), still


@pytest.mark.parametrize('parts', [PARTS, *({name: value} for name, value in PARTS.items())],
                         ids=['all', *PARTS])
def test_no_torque_is_unaccounted_for_whatever_resists(plant_of, witness_of, parts):
    plant = plant_of(arm='ur5_real', payload__mass=2.0, **parts)
    witness = witness_of(loaded_arm(plant.arm, 2.0, [0.0] * 3))
    wrench = np.array([20.0, -10.0, 15.0, 1.0, -2.0, 0.5])
    plant.apply_wrench(wrench[:3], wrench[3:])
    worst, stood = 0.0, 0
    for step in range(600):
        before = plant.truth
        command = witness.bias(before.q, before.qd) - witness.jacobian(before.q).T @ wrench
        command += witness.mass_matrix(before.q) @ (
            10.0 * np.sin(0.02 * step + np.arange(6)) - 5.0 * before.qd)
        after = plant.step(command)
        left, still = witnessed_torque(plant, witness, friction_of(parts), wrench, before, after)
        worst, stood = max(worst, np.abs(left).max()), stood + still.sum()
    assert worst < 1e-9
    print(f'residual with all that resists: {worst:.2g} N m')


def test_friction_takes_energy_whatever_its_parts():
    speeds = np.linspace(-6.0, 6.0, 401)[:, None] * np.ones(6)
    parts = dict(PARTS, friction__viscous_cubic=[-2.0] * 6)  # would drive the arm if it could
    for load in (0.0, 80.0):
        torque = friction_torque(friction_of(parts), speeds, np.full(6, load))
        assert (torque * speeds >= 0.0).all()


@pytest.mark.parametrize('name, value, words', [
    ('friction.static', [3.0] * 6, 'below friction.coulomb of 5 N m; give at least as much'),
    ('friction.stribeck_velocity', [0.0] * 6, 'friction.stribeck_velocity'),
    ('friction.load_factor', [-0.1] * 6, 'friction.load_factor'),
    ('friction.asymmetry', [1.0] * 6, 'friction.asymmetry'),
    ('friction_compensation.viscous_scale', [-0.1] * 6, 'friction_compensation.viscous_scale'),
    ('friction_compensation.coulomb_scale', [-0.1] * 6, 'friction_compensation.coulomb_scale'),
    ('torque_constant', [0.0] * 6, 'torque_constant'),
])
def test_friction_that_cannot_be_is_refused_in_one_line(name, value, words):
    with pytest.raises(InputError, match=words) as error:
        plant_from_parameters(complete(SIM_PARAMETERS, {'friction.coulomb': [5.0] * 6,
                                                        name: value}))
    assert '\n' not in str(error.value)


def test_an_arm_brings_its_friction_where_asked(plant_of):
    plant = plant_of(arm='ur5e_real', friction__from_arm=True,
                     friction__load_factor=[0.02] * 6)
    own = load_arm('ur5e_real').friction
    assert plant.parameters.friction_coulomb == own.coulomb.tolist()
    assert plant.parameters.friction_viscous_cubic == own.viscous_cubic.tolist()
    assert plant.parameters.friction_load_factor == [0.02] * 6
    assert plant_of(arm='ur5e_real').parameters.friction_coulomb == [0.0] * 6
