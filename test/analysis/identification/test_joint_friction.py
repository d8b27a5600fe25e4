"""Friction goes into the arm file with the parts that act, and the simulator's own comes back."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.data.run import Run, States
from ur5_ros.analysis.identification.arm_file import identified_yaml
from ur5_ros.analysis.identification.friction.families import (
    FEATURES,
    Family,
    choose_family,
    folds_of,
    friction_features,
)
from ur5_ros.analysis.identification.friction.joint_friction import joint_friction_of
from ur5_ros.analysis.identification.identify import identify, identify_payload
from ur5_ros.config import load_arm, parse_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.friction import JointFriction, friction_torque
from ur5_ros.model.parameters import with_payload

N = 4000
PARTS = {
    'Coulomb': {}, 'Stribeck 0.1 rad/s': {'static': 5.0, 'stribeck_velocity': 0.1},
    'load-dependent': {'load_factor': 0.08}, 'viscous cubic': {'viscous_cubic': -0.4},
    'asymmetric': {'asymmetry': 0.15},
}


def swinging(seed=0):
    """Return speeds from slow to fast in both directions, and loads, (n, 6)."""
    random = np.random.default_rng(seed)
    t = np.arange(N)[:, None] * 0.02
    speed = np.sin(0.9 * t + np.arange(6)) * (0.4 + 0.8 * np.sin(0.11 * t)**2)
    load = 20.0 * np.sin(0.37 * t + 1.0 + np.arange(6))
    return speed + 1e-6 * random.normal(size=(N, 6)), load


@pytest.mark.parametrize('part', PARTS)
def test_the_torque_of_the_models_friction_gives_its_parts_back(part):
    speed, load = swinging()
    more = {name: np.full(6, value) for name, value in PARTS[part].items()}
    true = JointFriction(viscous=np.full(6, 4.0), coulomb=np.full(6, 3.0), **more)
    torque = friction_torque(true, speed, load)
    features = friction_features(speed, np.sign(speed), load)
    block = folds_of(np.arange(N) // 40)
    noisy = torque + np.random.default_rng(1).normal(0.0, 0.02, torque.shape)
    families = [choose_family(features[:, i], np.zeros((N, 0)), noisy[:, i], block)
                for i in range(6)]
    found = joint_friction_of(families, features, noisy, np.ones((N, 6), dtype=bool))
    for name in ('viscous', 'coulomb', 'load_factor', 'viscous_cubic', 'asymmetry'):
        np.testing.assert_allclose(getattr(found, name), getattr(true, name), atol=0.02)
    np.testing.assert_allclose(found.static, true.static, atol=0.1)
    if 'static' in more:
        np.testing.assert_array_equal(found.stribeck_velocity, true.stribeck_velocity)
    np.testing.assert_allclose(friction_torque(found, speed, load), torque, atol=0.1)


def test_no_part_drives_a_joint_on():
    speed, load = swinging()
    features = friction_features(speed, np.sign(speed), load)
    family = Family(tuple(FEATURES.index(name) for name in (
        'viscous', 'Coulomb', 'load-dependent', 'Stribeck 0.05 rad/s')), 0.0, 0.0, 0.0)
    torque = 8.0 * speed - (0.5 + 0.03 * np.abs(load)) * np.sign(speed)
    found = joint_friction_of([family] * 6, features, torque, np.ones((N, 6), dtype=bool))
    assert found.coulomb.max() == 0.0 and found.load_factor.max() == 0.0
    assert found.static.max() == 0.0 and np.all(found.viscous > 0.0)


SIMULATED = {
    'friction.viscous': [8.0, 8.0, 5.0, 2.0, 2.0, 2.0],
    'friction.coulomb': [5.0, 5.0, 3.0, 1.0, 1.0, 1.0],
    'friction.static': [8.0, 5.0, 5.0, 1.5, 1.0, 1.0],
    'friction.stribeck_velocity': [0.1, 0.05, 0.1, 0.1, 0.05, 0.05],
    'friction.load_factor': [0.0, 0.1, 0.1, 0.0, 0.0, 0.0],
    'friction.asymmetry': [0.0, 0.0, 0.0, 0.0, 0.2, 0.0]}


def test_the_arm_file_of_a_simulated_arm_has_the_friction_that_was_simulated(looped):
    run = looped('exciting', duration=30.0, control_rate=500, sim=SIMULATED)
    arm = parse_arm(identified_yaml(identify([run], load_arm('ur5_real'))), 'identified')
    true = JointFriction(**{name.partition('.')[2]: np.array(value)
                            for name, value in SIMULATED.items()})
    speed = np.repeat(np.concatenate([-np.geomspace(0.02, 1.0, 9), np.geomspace(0.02, 1.0, 9)])[
        :, None], 6, axis=1)
    load = np.full(speed.shape, 15.0)
    np.testing.assert_allclose(friction_torque(arm.friction, speed, load),
                               friction_torque(true, speed, load), rtol=0.06)
    assert arm.friction.static[0] == pytest.approx(8.0, rel=0.05)
    assert arm.friction.load_factor[1] == pytest.approx(0.1, rel=0.1)
    assert arm.friction.asymmetry[4] == pytest.approx(0.2, abs=0.02)


HOME = np.radians([10.0, -80.0, 80.0, -90.0, -90.0, 20.0])
DRIVE = np.array([12.0, 12.0, 9.7, 10.3, 11.3, 15.4])
VISCOUS = np.array([20.0, 20.0, 10.0, 3.0, 3.0, 3.0])
COULOMB = np.array([14.0, 15.0, 9.0, 3.0, 2.4, 2.6])


def currents(arm, seed=1, warm=None, colder=0.0):
    """Return a recording of motor currents alone, at 100 Hz for 40 s."""
    random = np.random.default_rng(seed)
    t = np.arange(0.0, 40.0, 0.01)
    q, qd, qdd = np.tile(HOME, (len(t), 1)), np.zeros((len(t), 6)), np.zeros((len(t), 6))
    for joint in range(6):
        for k in range(1, 6):
            w, a, phase = 0.7 * k, random.uniform(0.1, 0.3) / np.sqrt(k), random.uniform(0, 6.3)
            q[:, joint] += a * np.sin(w * t + phase)
            qd[:, joint] += a * w * np.cos(w * t + phase)
            qdd[:, joint] -= a * w**2 * np.sin(w * t + phase)
    less = np.ones_like(q) if warm is None else 1.0 - colder * (warm - warm.mean(axis=0))
    resist = less * (VISCOUS * qd + COULOMB * np.sign(qd))
    current = (inverse_dynamics(q + arm.angle_offset, qd, qdd, arm) + resist) / DRIVE
    current += random.normal(0.0, 0.03, current.shape)
    stamp = np.rint(t * 1e9).astype(np.int64) + 1_000_000
    return Run(f'currents {seed}', stamp, States(q, qd, np.full_like(q, np.nan)), 100.0,
               current=current, temperature=warm)


def test_drives_and_friction_of_a_known_arm_are_found_from_currents_only():
    arm = load_arm('ur10e_real')
    found = identify([currents(arm)], arm, currents(arm, 2), name='driven')
    assert found.motors is not None and found.base == {}
    np.testing.assert_allclose(found.motors.drive[:3], DRIVE[:3], rtol=0.03)
    assert np.all(np.abs(found.motors.drive - DRIVE) < 4.0 * found.motors.drive_error + 0.01)
    np.testing.assert_allclose(found.motors.coulomb, COULOMB, rtol=0.1)
    assert np.all(found.motors.current_rms < 0.1)
    written = parse_arm(identified_yaml(found), 'driven')
    np.testing.assert_array_equal(written.mass, arm.mass)  # currents do not scale masses
    np.testing.assert_allclose(written.friction.coulomb, COULOMB, rtol=0.1)
    assert any('none of them was identified' in sentence for sentence in found.sentences())
    assert 'nan' not in identified_yaml(found)


def test_a_drive_whose_torque_is_hidden_by_friction_is_not_excited_by_name():
    arm = load_arm('ur5e')  # its last wrist carries nothing
    run = currents(arm)
    found = identify([run], arm)
    assert found.motors is not None
    assert np.isnan(found.motors.drive[5]) and np.isfinite(found.motors.drive[:4]).all()
    text = '; '.join(found.sentences())
    assert 'not excited: the drives of' in text and 'wrist_3_joint' in text and 'nan' not in text


def test_a_load_is_found_from_currents_only():
    arm = load_arm('ur10e_real')
    load = currents(with_payload(arm, 2.5, (0.0, 0.02, 0.05)), 3)
    found = identify([currents(arm)], arm, payload=load).payload
    assert found is not None and found.quantity == 'current'
    assert found.mass == pytest.approx(2.5, rel=0.05)
    with pytest.raises(InputError, match='ur5 identify UNLOADED --payload LOADED'):
        identify_payload(load, arm)


def test_runs_with_and_without_torque_are_not_mixed():
    arm = load_arm('ur10e_real')
    run = currents(arm)
    other = replace(run, states=run.states._replace(effort=run.current * DRIVE))
    with pytest.raises(InputError, match='give runs of one kind'):
        identify([run, other], arm)


def test_friction_that_falls_with_the_temperature_is_found_from_recorded_ones():
    arm = load_arm('ur10e_real')
    warm = 25.0 + np.outer(np.linspace(0.0, 15.0, 4000), np.ones(6))
    found = identify([currents(arm, 4, warm, 0.02)], arm).motors
    assert found is not None
    for joint in range(3):
        assert 'by temperature' in found.family[joint].name
        terms = found.terms[joint]
        slope = sum(terms[name][0] for name in terms if name.startswith('viscous by')) / VISCOUS[
            joint]
        assert slope == pytest.approx(-0.02, abs=0.006)
    cold = identify([currents(arm, 4, warm, 0.0)], arm).motors
    assert cold is not None
    assert not any('temperature' in family.name for family in cold.family)
