"""Causes are what a body can have, arms are compared whole, and a motion may not tell."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.effort import effort_check
from ur5_ros.analysis.data.run import NodeRecord, Run, States
from ur5_ros.analysis.diagnosis.plant import plant_causes
from ur5_ros.analysis.validate import validate
from ur5_ros.config import arm_text
from ur5_ros.config.arms import load_arm
from ur5_ros.config.validation import load_marks
from ur5_ros.model.dynamics import gravity_torque, inverse_dynamics
from ur5_ros.model.parameters import with_payload

ARM = load_arm('ur5e')


def recorded(q, qd, effort, rate=100.0, gaps=0):
    """Return a run of a robot: states and torques, nothing more; seconds of gap in each row."""
    stamp = ((np.arange(len(q)) / rate + gaps) * 1e9).astype(np.int64) + 1_000_000
    return Run('recorded', stamp, States(q, qd, effort), rate)


def swinging(arm, seconds=20.0, rate=100.0, gravity=None):
    """Return a run of an arm that swings on every joint."""
    t = np.arange(0.0, seconds, 1.0 / rate)[:, None]
    w = np.array([0.8, 1.1, 1.3, 1.7, 2.1, 2.6])
    home = np.radians([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
    q, qd, qdd = (home + 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t),
                  -0.5 * w**2 * np.sin(w * t))
    plant = arm if gravity is None else replace(arm, gravity=np.array(gravity))
    return recorded(q, qd, inverse_dynamics(q, qd, qdd, plant), rate)


def standing(arm, poses, noise=0.0, seconds=2.0, rate=100.0):
    """Return a run of an arm that stands still in one pose after the other, a gap between."""
    q = np.repeat(np.array(poses, dtype=float), int(seconds * rate), axis=0)
    shaken = np.random.default_rng(1).normal(0.0, 1.0, (2, *q.shape)) * noise
    gaps = np.repeat(np.arange(len(poses)), int(seconds * rate))
    return recorded(q + 0.01 * shaken[0], shaken[1], gravity_torque(q, arm), rate, gaps)


def test_a_mismatch_of_whole_parameter_sets_names_every_parameter(looped):
    run = looped('kebria_fig11', 'ur5', control_arm='ur5_description', duration=4.0)
    cause, = validate(run).causes
    assert cause['kind'] == 'wrong arm' and cause['arm'] == 'ur5'
    law, plant = load_arm('ur5_description'), load_arm('ur5')
    found = {each['parameter']: each for each in cause['differences']}
    # every difference of the two files, and no other
    expected = {f'mass {i + 1}' for i in range(6) if law.mass[i] != plant.mass[i]}
    expected |= {f'centre of mass {i + 1}' for i in range(6) if np.any(law.com[i] != plant.com[i])}
    expected |= {f'tensor {i + 1}' for i in range(6)
               if np.any(np.abs(law.inertia[i] - plant.inertia[i]) > 1e-12)}
    assert set(found) == expected
    first = cause['differences'][0]
    assert first['parameter'] == 'centre of mass 3'
    assert first['plant'][0] == 0.11993 and first['law'][0] == 0.15
    assert '0.11993' in cause['sentence'] and 'tensor of link 2' in cause['sentence']
    # mending the mass alone makes it worse; mending what is named mends the run
    assert found['mass 3']['alone'] < 0.0 < found['centre of mass 3']['alone']
    assert cause['differences'][-1]['together'] == pytest.approx(1.0, abs=1e-9)
    assert cause['mended_rms'] < 1e-9 < cause['unexplained_rms']


def test_correcting_one_parameter_leaves_what_the_equations_say(looped):
    # witness: the same motion through inverse dynamics with that one parameter exchanged
    run = looped('multi_sine', 'ur5', control_arm='ur5_description', duration=3.0)
    cause, = validate(run).causes
    law, plant = load_arm('ur5_description'), load_arm('ur5')
    q, qd, effort = run.states
    qdd = np.diff(qd, axis=0) * run.control_rate

    def left(arm):
        wrong = effort[1:] - inverse_dynamics(q[:-1], qd[:-1], qdd, arm)
        return np.sum(wrong**2)

    com = law.com.copy()
    com[2] = plant.com[2]
    alone = 1.0 - left(replace(law, com=com)) / left(law)
    found = {each['parameter']: each['alone'] for each in cause['differences']}
    assert found['centre of mass 3'] == pytest.approx(alone, abs=0.03)


@pytest.mark.parametrize('gravity, turned, words', [
    ([0.0, 0.0, 9.81], 180.0, 'ceiling'), ([9.81, 0.0, 0.0], 90.0, 'wall'),
    ([0.0, -6.9367, -6.9367], 45.0, 'tilted')])
def test_the_direction_of_gravity_is_named(looped, tmp_path, gravity, turned, words):
    text = arm_text('ur5e')
    assert 'value: [0.0, 0.0, -9.81]' in text
    file = tmp_path / 'mounted.yaml'
    file.write_text(text.replace('value: [0.0, 0.0, -9.81]', f'value: {gravity}'))
    causes = validate(looped('multi_sine', str(file), control_arm='ur5e')).causes
    assert [cause['kind'] for cause in causes] == ['gravity']
    assert causes[0]['turned_deg'] == pytest.approx(turned, abs=0.01)
    np.testing.assert_allclose(causes[0]['gravity'], gravity, atol=1e-6)
    assert words in causes[0]['sentence'] and 'along [' in causes[0]['sentence']


@pytest.mark.parametrize('what, spoil', [
    ('a tenth', lambda run: 0.1 * run.states.effort),
    ('other sign', lambda run: -run.states.effort),
    ('amperes', lambda run: run.states.effort / [12.0, 12.0, 10.0, 10.0, 11.0, 15.0]),
    ('noise', lambda run: np.random.default_rng(0).normal(0.0, 20.0, run.states.effort.shape)),
    ('constant', lambda run: np.full_like(run.states.effort, 3.0)),
    ('gravity excluded', lambda run: run.states.effort - gravity_torque(run.states.q, ARM))])
def test_no_cause_is_named_that_no_body_can_have(what, spoil):
    run = swinging(ARM)
    run = replace(run, states=run.states._replace(effort=spoil(run)))
    for cause in plant_causes(run, ARM):
        if 'mass_kg' in cause:
            assert cause['mass_kg'] > 0.0
            assert np.linalg.norm(cause['com_m']) < 1.5
        for joint in cause.get('joints', {}).values():
            assert joint['value'] >= 0.0, cause
        assert 0.0 <= cause['share'] <= 1.0 and np.isfinite(cause['share'])
        assert 'nan' not in cause['sentence']


@pytest.mark.parametrize('noise', [0.0, 1e-3])
def test_a_load_is_found_in_an_arm_that_stands_in_several_poses(noise):
    poses = np.random.default_rng(2).uniform(-1.5, 1.5, (12, 6))
    load = with_payload(ARM, 2.0, (0.02, -0.01, 0.06))
    cause, *others = plant_causes(standing(load, poses, noise), ARM)
    assert cause['kind'] == 'payload'
    assert {other['kind'] for other in others} <= ({'unexplained'} if noise else set())
    assert cause['mass_kg'] == pytest.approx(2.0, rel=0.02)


def test_in_one_pose_the_load_is_not_given_a_centre_that_the_motion_does_not_determine():
    pose = np.radians([[20.0, -75.0, 90.0, -105.0, -80.0, 15.0]])
    found = plant_causes(standing(with_payload(ARM, 2.0, (0.02, 0.0, 0.06)), pose, 0.0, 20.0), ARM)
    assert 'does not determine' in ' '.join(cause['sentence'] for cause in found)
    for cause in found:
        if 'mass_kg' in cause:
            assert cause['mass_kg'] == pytest.approx(2.0, rel=0.05)


def test_an_arm_at_rest_that_agrees_has_no_cause():
    pose = np.radians([[20.0, -75.0, 90.0, -105.0, -80.0, 15.0]])
    assert plant_causes(standing(ARM, pose, 0.0, 20.0), ARM) == []


def test_a_load_that_was_declared_and_is_not_there_is_named_as_less():
    declared = with_payload(ARM, 2.0, (0.0, 0.0, 0.05))
    cause, = plant_causes(swinging(ARM), declared)
    assert cause['kind'] == 'payload' and cause['mass_kg'] == pytest.approx(-2.0, abs=0.02)
    assert '2 +-' in cause['sentence'] and 'less at the tool' in cause['sentence']


def alone(joints, effort, seconds=3.0, amplitude=0.3, speed=2.5, noise=0.05):
    """Return a run that moves some joints, its torque that of the arm and a function's."""
    t = np.arange(0.0, seconds, 0.002)[:, None]
    swing = np.where(np.isin(np.arange(6), joints), amplitude, 0.0)
    w = speed * np.array([1.0, 0.8, 1.2, 1.4, 1.7, 2.0])
    home = np.array([0.4, -1.5, 1.4, -1.8, -1.2, 0.4])
    q, qd, qdd = (home + swing * np.sin(w * t), swing * w * np.cos(w * t),
                  -swing * w**2 * np.sin(w * t))
    shaken = np.random.default_rng(1).normal(0.0, noise, q.shape)
    return recorded(q, qd, effort(q, qd, qdd) + shaken, 500.0)


def with_rotors(q, qd, qdd):
    return inverse_dynamics(q, qd, qdd, ARM) + qdd * [2.0, 2.0, 2.0, 0.5, 0.5, 0.5]


@pytest.mark.parametrize('noise', [0.0, 0.05])
def test_no_load_is_named_that_no_arm_could_carry(noise):
    run = alone([5], with_rotors, noise=noise)
    found = effort_check(replace(run, control=NodeRecord('ur5e', ARM, {'mode': 'unknown'})),
                         load_marks())
    assert 'with a load' not in found.sentence and found.verdict == 'pass', found.sentence


@pytest.mark.parametrize('mass', [0.5, 1.2])
def test_a_gravity_that_is_the_same_by_size_and_direction_is_no_cause(mass):
    other = replace(ARM, mass=ARM.mass * [1.0, 1.0, mass, 1.0, 1.0, 1.0])
    run = alone([3, 4, 5], lambda q, qd, qdd: inverse_dynamics(q, qd, qdd, other), noise=0.0)
    for cause in plant_causes(run, ARM):
        if 'gravity' in cause:
            away = np.linalg.norm(np.subtract(cause['gravity'], ARM.gravity))
            assert away > 1e-3 * 9.81, cause['sentence']


@pytest.mark.parametrize('speed, both_ways', [(2.5, True), (0.2, False)])
def test_friction_of_joints_that_never_turn_back_may_be_an_offset_and_says_so(speed, both_ways):
    dry = np.array([5.0, 5.0, 5.0, 1.0, 1.0, 1.0])
    run = alone(range(6), lambda q, qd, qdd: inverse_dynamics(q, qd, qdd, ARM) + dry * np.sign(qd),
                speed=speed, noise=0.0)
    cause, = plant_causes(run, ARM)
    assert cause['kind'] == 'Coulomb friction'
    assert ('an offset or a load would look the same' in cause['sentence']) is not both_ways
    assert len(cause.get('one_way', ())) == (0 if both_ways else 6)


@pytest.mark.parametrize('speed, known', [(2.5, True), (0.2, False)])
def test_a_centre_of_mass_that_noise_hides_is_not_named(speed, known):
    load = with_payload(ARM, 2.0, (0.0, 0.0, 0.1))
    run = alone(range(6), lambda q, qd, qdd: inverse_dynamics(q, qd, qdd, load), speed=speed,
                amplitude=0.3 if known else 0.05)
    cause = next(each for each in plant_causes(run, ARM) if each['kind'] == 'payload')
    assert cause['mass_kg'] == pytest.approx(2.0, abs=5.0 * cause['mass_error_kg'])
    assert ('centre of mass at' in cause['sentence']) is known
    assert known is bool(np.isfinite(cause['com_m']).all())
    if known:
        away = np.abs(np.subtract(cause['com_m'], (0.0, 0.0, 0.1)))
        assert (away < 5.0 * np.array(cause['com_error_m'])).all()


def test_a_cause_of_no_certain_size_is_named_as_not_determined():
    heavier = replace(ARM, mass=1.2 * ARM.mass, inertia=1.2 * ARM.inertia)
    run = alone(range(6), lambda q, qd, qdd: inverse_dynamics(q, qd, qdd, heavier), speed=0.2,
                amplitude=0.05)
    vague = [cause for cause in plant_causes(run, ARM) if cause.get('joints') == {}]
    assert vague and all('does not determine how much' in cause['sentence'] for cause in vague)
