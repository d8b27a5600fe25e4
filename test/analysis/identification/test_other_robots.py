"""Recordings as robots of others leave them: torque, current, load and friction are found."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.data.run import Run, States
from ur5_ros.analysis.identification.arm_file import identified_yaml
from ur5_ros.analysis.identification.identify import identify, identify_payload
from ur5_ros.analysis.identification.inertia import pseudo_inertia
from ur5_ros.analysis.identification.simulation_gate import simulate
from ur5_ros.config import load_arm, parse_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import with_payload
from ur5_ros.model.regressor import inertial_parameters
from ur5_ros.signals import Reference

HOME = np.radians([10.0, -80.0, 80.0, -90.0, -90.0, 20.0])
DRIVE = np.array([12.0, 12.0, 9.7, 10.3, 11.3, 15.4])
VISCOUS, COULOMB = np.array([20.0, 20.0, 10.0, 3.0, 3.0, 3.0]), np.array(
    [14.0, 15.0, 9.0, 3.0, 2.4, 2.6])


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter('error', RuntimeWarning)
        yield


def motion(seconds=30.0, rate=100.0, seed=0, still=()):
    """Return t, q, qd, qdd of five harmonics on every joint, starting anywhere."""
    random = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate)
    q, qd, qdd = np.tile(HOME, (len(t), 1)), np.zeros((len(t), 6)), np.zeros((len(t), 6))
    for joint in set(range(6)) - set(still):
        for k in range(1, 6):
            w, a, phase = 0.7 * k, random.uniform(0.1, 0.3) / np.sqrt(k), random.uniform(0, 6.3)
            q[:, joint] += a * np.sin(w * t + phase)
            qd[:, joint] += a * w * np.cos(w * t + phase)
            qdd[:, joint] -= a * w**2 * np.sin(w * t + phase)
    return t, q, qd, qdd


def robot(arm, seed=0, load=None, friction=True, asymmetric=0.0, cubic=0.0, **more):
    """
    Return a log: target torque of the arm, currents with friction and load, at about 100 Hz.

    Speeds are quantised and noisy and stamps jitter by a fifth, as in public recordings.

    """
    random = np.random.default_rng(100 + seed)
    t, q, qd, qdd = motion(seed=seed, **more)
    torque = inverse_dynamics(q, qd, qdd, arm)
    moved = torque if load is None else inverse_dynamics(q, qd, qdd, load)
    resist = VISCOUS * qd + COULOMB * (np.sign(qd) + asymmetric) + cubic * VISCOUS * qd**3
    current = (moved + (resist if friction else 0.0)) / DRIVE
    current += random.normal(0.0, 0.05, current.shape)
    stamp = np.rint(t * 1e9).astype(np.int64) + 1_000_000
    noisy = np.round(qd + random.normal(0.0, 2e-3, qd.shape), 4)
    return Run(f'log {seed}', stamp, States(np.round(q, 4), noisy, torque), 100.0,
               current=current)


def is_physical(arm):
    links = inertial_parameters(arm).reshape(6, 10)
    return min(np.linalg.eigvalsh(pseudo_inertia(body))[0] for body in links) > 0.0


def test_what_a_controller_computes_with_is_found_from_its_target_torque():
    true = load_arm('ur10e_controller')
    found = identify([robot(true, seed) for seed in (1, 2)], load_arm('ur10e'), robot(true, 3))
    assert np.all(found.test_rms < [0.13, 0.18, 0.09, 0.015, 0.012, 0.008])
    np.testing.assert_allclose(found.arm.armature[3:], true.armature[3:], rtol=0.01)
    assert [family.features for family in found.family] == [()] * 6  # no friction in it
    assert is_physical(found.arm)


def test_drives_and_friction_are_found_from_currents_and_the_family_by_motion_left_out():
    true = load_arm('ur10e_controller')
    found = identify([robot(true, seed, cubic=-0.2) for seed in (1, 2)], load_arm('ur10e'),
                     robot(true, 3, cubic=-0.2)).motors
    np.testing.assert_allclose(found.drive, DRIVE, rtol=0.08)  # wrists: the term is not chosen
    for family, terms in zip(found.family[:3], found.terms[:3], strict=True):
        assert 'viscous cubic' in family.name and terms['viscous cubic'][0] < 0.0
    assert np.all(found.current_rms[:3] < found.current_rms_linear[:3])
    plain = identify([robot(true, 1)], load_arm('ur10e')).motors
    assert all(family.name == 'viscous and Coulomb' for family in plain.family)
    np.testing.assert_allclose(plain.coulomb, COULOMB, rtol=0.1)
    assert np.all(np.abs(plain.drive - DRIVE) < 4.0 * plain.drive_error)


@pytest.mark.parametrize('mass', [0.0, 2.8])
def test_a_load_is_found_from_currents_of_a_run_with_and_one_without_it(mass):
    true = load_arm('ur10e_controller')
    load = with_payload(true, mass, (0.03, 0.0, 0.05)) if mass else true
    found = identify([robot(true, 1)], load_arm('ur10e'), payload=robot(true, 2, load)).payload
    assert found.quantity == 'current'
    assert abs(found.mass - mass) < max(0.05 * mass, 0.1)
    assert abs(found.mass - mass) < 4.0 * found.mass_error + 0.01
    if mass:
        np.testing.assert_allclose(found.com, [0.03, 0.0, 0.05], atol=0.02)


def test_a_robot_guided_by_hand_shows_its_load_only_by_gravity():
    arm = load_arm('ur5e')
    t, q, qd, _ = motion(8.0)
    loaded = replace(with_payload(arm, 1.28, (0.001, -0.001, 0.053)),
                     gravity=np.array([0.0, 0.0, -9.82]))
    stamp = np.rint(t * 1e9).astype(np.int64) + 1_000_000
    run = Run('guided', stamp, States(q, qd, gravity_torque(q, loaded)), 100.0,
              reference=Reference(q, qd, np.zeros_like(q)), follows_reference=True)
    found = identify_payload(run, arm)
    assert found.quantity == 'torque' and found.mass == pytest.approx(1.28, rel=0.03)
    with pytest.raises(InputError, match='does not move|not excited'):
        identify([run], arm)


def test_measured_effort_gives_coulomb_friction_within_a_tenth():
    arm = load_arm('ur10')
    t, q, qd, qdd = motion(30.0, 125.0)
    effort = inverse_dynamics(q, qd, qdd, arm) + VISCOUS * qd + COULOMB * np.sign(qd)
    effort += np.random.default_rng(1).normal(0.0, 1.0, effort.shape)
    stamp = np.rint(t * 1e9).astype(np.int64)
    found = identify([Run('measured', stamp, States(q, qd, effort), 125.0)], arm)
    np.testing.assert_allclose(found.coulomb, COULOMB, rtol=0.1)
    np.testing.assert_allclose(found.viscous, VISCOUS, rtol=0.15)
    np.testing.assert_allclose(found.arm.friction.coulomb, found.coulomb)


@pytest.mark.parametrize('noise', [{}, {'noise.velocity': 1e-3, 'noise.position': 1e-5}],
                         ids=['exact', 'noisy'])
def test_only_the_joint_states_of_a_simulated_run_give_an_arm_that_moves(looped, noise):
    run = looped('exciting', duration=20.0, control_rate=500, sim=noise)
    alone = Run('alone', run.stamp, run.states, run.control_rate)
    found = identify([alone], load_arm('ur5'))
    arm = parse_arm(identified_yaml(found), 'alone')
    assert is_physical(arm) and simulate(arm) < 0.1
    assert np.all(found.test_rms < 0.05 * found.torque_rms + 0.02)
    assert 'nan' not in identified_yaml(found)


def test_what_a_motion_does_not_excite_is_named_and_not_changed():
    arm = load_arm('ur5_real')
    t, q, qd, qdd = motion(20.0)
    # the last wrist hardly moves: its tensor and rotor stay what they were
    q[:, 5] = HOME[5] + 0.02 * (q[:, 5] - HOME[5])
    qd[:, 5], qdd[:, 5] = 0.02 * qd[:, 5], 0.02 * qdd[:, 5]
    effort = inverse_dynamics(q, qd, qdd, arm)
    effort += np.random.default_rng(2).normal(0.0, 0.5, effort.shape)
    stamp = np.rint(t * 1e9).astype(np.int64)
    found = identify([Run('lazy', stamp, States(q, qd, effort), 100.0)], arm)
    assert 'rotor6' in found.not_excited and 'rotor6' not in found.base
    assert found.arm.armature[5] == pytest.approx(arm.armature[5], rel=0.2)
    assert any('not excited' in sentence for sentence in found.sentences())


@pytest.mark.parametrize('still', [(5,), (0, 3)])
def test_a_joint_that_stands_still_is_refused_by_name(still):
    run = robot(load_arm('ur10e_controller'), 1, still=still)
    quiet = run.states._replace(qd=np.where(np.isin(np.arange(6), still), 0.0, run.states.qd))
    with pytest.raises(InputError, match='does not move'):
        identify([replace(run, states=quiet)], load_arm('ur10e'))


def test_too_short_a_run_is_refused():
    run = robot(load_arm('ur10e_controller'), 1, seconds=0.1)
    with pytest.raises(InputError, match='too few states'):
        identify([run], load_arm('ur10e'))


def test_without_an_arm_the_known_ones_that_fit_are_named():
    with pytest.raises(InputError, match='--arm NAME.*ur10e_controller'):
        identify([robot(load_arm('ur10e_controller'), 1)])
