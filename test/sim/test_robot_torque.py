"""What the robot does with a commanded torque: compensation, feedback, payload, torque mode."""

import json

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.friction import friction_compensation
from ur5_ros.sim.payload import loaded_arm

ZERO = np.zeros(6)
UR_VISCOUS, UR_COULOMB = [0.9, 0.9, 0.8, 0.9, 0.9, 0.9], [0.8, 0.8, 0.7, 0.8, 0.8, 0.8]
#: UR's torque mode without waiting: zero means hold still, friction is compensated as shipped.
AS_SHIPPED = {
    'arm': 'ur5e_real', 'friction__from_arm': True, 'effort_convention': 'gravity_excluded',
    'friction_compensation__viscous_scale': UR_VISCOUS,
    'friction_compensation__coulomb_scale': UR_COULOMB}


def kinds(plant):
    return [each.kind for each in plant.drain_events()]


def test_a_joint_in_motion_gets_its_compensation_and_one_at_rest_none(plant_of):
    plant = plant_of(initial_velocities=[0.5, -0.5, 0.0, 1.0, 0.0, -1.0], **AS_SHIPPED)
    qd, friction = plant.truth.qd, load_arm('ur5e_real').friction
    gravity = gravity_torque(plant.truth.q, plant.arm)
    added = plant.step(ZERO).effort - gravity
    np.testing.assert_allclose(added, friction_compensation(
        friction, qd, np.array(UR_VISCOUS), np.array(UR_COULOMB)), atol=1e-12)
    assert np.abs(added[[2, 4]]).max() < 1e-12
    viscous = friction.viscous + friction.viscous_quadratic * 0.5 + friction.viscous_cubic * 0.25
    assert added[0] == pytest.approx(0.9 * viscous[0] * 0.5 + 0.8 * friction.coulomb[0])


def test_compensation_follows_the_measured_speed_not_the_true_one(plant_of):
    plant = plant_of(initial_velocities=[0.5] * 6, delay__state_periods=3, **AS_SHIPPED)
    first = plant.state.qd
    for _ in range(4):
        before = plant.truth
        state = plant.step(ZERO)
    gravity = gravity_torque(before.q, plant.arm)
    np.testing.assert_allclose(
        plant.truth.effort - gravity, friction_compensation(
            plant.arm.friction, first, np.array(UR_VISCOUS), np.array(UR_COULOMB)), atol=1e-12)
    assert not np.array_equal(state.qd, plant.truth.qd)


def test_dead_zone_of_torque_mode(plant_of):
    plant = plant_of(friction__load_factor=[0.05] * 6, **AS_SHIPPED)
    gravity = gravity_torque(plant.truth.q, plant.arm)
    friction = load_arm('ur5e_real').friction
    least = (1.0 + friction.asymmetry) * (friction.static + 0.05 * np.abs(gravity))
    start = plant.truth.q
    for _ in range(10_000):
        state = plant.step(0.99 * least)
    assert np.abs(state.q - start).max() < 1e-9
    for joint in range(6):
        plant.reset()
        for _ in range(10_000):
            state = plant.step(np.where(np.arange(6) == joint, 1.01 * least, 0.0))
            if abs(state.q[joint] - start[joint]) > 1e-3:
                break
        assert state.q[joint] - start[joint] > 1e-3
    print(f'dead zone of joint 1 to 6: {np.round(least, 2).tolist()} N m, moved within 1 %')


@pytest.mark.parametrize('feedback', ['total', 'gravity_excluded', 'current'])
def test_effort_is_reported_as_the_drives_do(plant_of, feedback):
    plant = plant_of(arm='ur5e', effort_feedback=feedback, payload__mass=1.0)
    rng = np.random.default_rng(1)
    assert not plant.state.effort.any()
    for _ in range(5):
        gravity = gravity_torque(plant.truth.q, plant.arm)
        reported, total = plant.step(gravity + rng.normal(size=6)).effort, plant.truth.effort
        expected = {'total': total, 'gravity_excluded': total - gravity,
                    'current': total / plant.parameters.torque_constant}[feedback]
        np.testing.assert_allclose(reported, expected, atol=1e-12)


def test_a_payload_with_a_tensor_is_the_body_that_pinocchio_has(plant_of, witness_of):
    load = 2.0, [0.02, 0.0, 0.1], [0.02, 0.03, 0.025, 0.001, 0.0, -0.002]
    plant = plant_of(arm='ur5e', payload__mass=load[0], payload__com=load[1],
                     payload__inertia=load[2])
    witness = witness_of(loaded_arm(plant.arm, *load))
    rng = np.random.default_rng(2)
    for _ in range(100):
        q, qd = plant.truth.q, plant.truth.qd
        command = witness.bias(q, qd) + witness.mass_matrix(q) @ rng.uniform(-5.0, 5.0, 6)
        after = plant.step(command)
        left = (witness.mass_matrix(q) @ (after.qd - qd) / 1e-3 + witness.bias(q, qd)
                - after.effort)
        assert np.abs(left).max() < 1e-9


def test_a_payload_is_exchanged_in_stages_over_its_transition_time(plant_of):
    plant = plant_of(arm='ur5e', control_rate=500, payload__transition_time=0.2,
                     effort_convention='gravity_excluded')
    plant.change('payload.mass', 2.0)
    plant.change('payload.com', [0.0, 0.0, 0.1])
    plant.change('payload.inertia', [0.01, 0.01, 0.01, 0.0, 0.0, 0.0])
    masses, sag = [], []
    for _ in range(150):
        sag.append(plant.step(ZERO).qd)
        masses += [json.loads(each.values['mass']) for each in plant.drain_events()
                   if each.kind == 'payload']
    assert len(masses) == 100 and masses[-1] == 2.0
    np.testing.assert_allclose(np.diff(masses), 0.02, atol=1e-12)
    assert np.abs(np.diff(sag[:100], axis=0)).max() < 0.1
    plant.change('payload.transition_time', 0.0)
    plant.drain_events()
    plant.change('payload.mass', 1.0)
    plant.step(ZERO)
    assert 'payload' not in kinds(plant)


@pytest.mark.parametrize('name, value, words', [
    ('payload.inertia', [0.01] * 3 + [0.0] * 3, 'payload has a tensor and no mass'),
    ('payload.inertia', [-1.0] + [0.0] * 5, 'payload inertia'),
])
def test_a_payload_that_is_no_body_is_refused_and_changes_nothing(plant_of, name, value, words):
    plant = plant_of(arm='ur5e')
    with pytest.raises(InputError, match=words) as error:
        plant.change(name, value)
    assert '\n' not in str(error.value) and plant.parameters.by_name()[name] == [0.0] * 6


def test_silence_ends_torque_mode_where_it_is_asked_to(plant_of):
    plant = plant_of(leave_torque_mode=True, **AS_SHIPPED)
    push = np.array([20.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(100):
        plant.step(push)
    assert kinds(plant) == ['torque_mode'] and plant.truth.qd[0] > 0.1
    plant.step(None)
    for _ in range(500):
        plant.step(push)  # not listened to
    assert kinds(plant) == ['torque_mode', 'fallback'] and np.abs(plant.truth.qd).max() < 1e-9
    assert 'next command' in plant.resume_torque_mode()
    for _ in range(100):
        plant.step(push)
    assert kinds(plant) == ['torque_mode', 'fallback'] and plant.truth.qd[0] > 0.1


def test_by_default_the_next_command_enters_torque_mode_again(plant_of):
    plant = plant_of(**AS_SHIPPED)
    for command in (ZERO, None, ZERO):
        plant.step(command)
    assert kinds(plant) == ['fallback', 'fallback']
    assert 'was not left' in plant.resume_torque_mode()


def test_a_protective_stop_is_not_resumed_but_reset(plant_of):
    plant = plant_of(overspeed_stop=True, leave_torque_mode=True,
                     initial_velocities=[4.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    plant.step(ZERO)
    assert plant.stopped and '~/reset' in plant.resume_torque_mode()


def test_commands_are_limited_in_size_and_rate(plant_of):
    plant = plant_of(arm='ur5e', gravity=[0.0, 0.0, 0.0], torque_limit=[50.0] * 3 + [5.0] * 3,
                     torque_rate_limit=2000.0)
    efforts = np.array([plant.step(np.full(6, 100.0)).effort for _ in range(40)])
    np.testing.assert_allclose(efforts[:, 0], np.minimum(2.0 * np.arange(1, 41), 50.0))
    np.testing.assert_allclose(efforts[:, 5], np.minimum(2.0 * np.arange(1, 41), 5.0))
    assert 'limit' in kinds(plant)
    np.testing.assert_allclose(plant.step(np.full(6, -100.0)).effort, efforts[-1] - 2.0)
