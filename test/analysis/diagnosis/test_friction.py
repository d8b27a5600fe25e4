"""Friction that a joint has, and what a robot compensates of it: each made, each named apart."""

import json

import numpy as np
import pytest
from thorough import times

from ur5_ros.analysis.data.run import NodeRecord, RecordedEvent, Run, States
from ur5_ros.analysis.diagnosis.compensation import NAME
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.plant import Plant


def some(values):
    """Return all values in a thorough run, else the first one."""
    return times(values[:1], values)


SEEDS = some([1, 2, 3])
FRICTION = {'friction.viscous': [5.0, 5.0, 5.0, 1.0, 1.0, 1.0],
            'friction.coulomb': [3.0, 3.0, 3.0, 0.6, 0.6, 0.3]}
NEW = {'stiction', 'Stribeck friction', 'load-dependent friction', 'over-compensation',
       'under-compensation'}


def sizes(size):
    """Return a torque for each joint, less for the wrists."""
    return [size, size, size, 0.2 * size, 0.2 * size, 0.1 * size]


def noisy(seed, **more):
    return {'noise.velocity': 1e-4, 'noise.position': 1e-5, 'seed': seed, **more}


def found(result):
    return [cause['kind'] for cause in result.causes]


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize('size', some([0.5, 2.0, 5.0]))
def test_stiction(looped, size, seed):
    result = validate(looped(sim=noisy(seed, **{
        'friction.static': sizes(size), 'friction.stribeck_velocity': [1e-3] * 6})))
    assert result.verdict == 'fail' and found(result) == ['stiction']
    named = result.causes[0]['joints']
    assert len(named) >= 3
    for name, each in named.items():
        made = sizes(size)[JOINT_NAMES.index(name)]
        assert 0.9 * made < each['value'] <= made * (1.0 + 1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize('size, velocity', some([(0.5, 0.2), (2.0, 0.1), (5.0, 0.3)]))
def test_stribeck_friction(looped, size, velocity, seed):
    result = validate(looped(sim=noisy(seed, **{
        'friction.static': sizes(size), 'friction.stribeck_velocity': [velocity] * 6})))
    assert result.verdict == 'fail' and found(result) == ['Stribeck friction']
    cause = result.causes[0]
    assert cause['velocity'] == pytest.approx(velocity, rel=1e-3)
    assert cause['joints']['shoulder_pan_joint']['value'] == pytest.approx(size, rel=1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize('share', some([0.01, 0.03, 0.1]))
def test_load_dependent_friction(looped, share, seed):
    result = validate(looped(sim=noisy(seed, **{'friction.load_factor': [share] * 6})))
    assert result.verdict == 'fail' and found(result) == ['load-dependent friction']
    assert result.causes[0]['joints']['elbow_joint']['value'] == pytest.approx(share, rel=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize('share', [*some([0.9, 0.7, 0.5]), *some([1.1, 1.2, 1.3])])
def test_under_and_over_compensation(looped, share, seed):
    result = validate(looped(sim=noisy(seed, **FRICTION, **{
        'friction_compensation.viscous_scale': [share] * 6,
        'friction_compensation.coulomb_scale': [share] * 6})))
    kind = 'over-compensation' if share > 1.0 else 'under-compensation'
    assert result.verdict == 'fail' and found(result)[0] == kind
    assert NEW.intersection(found(result)) == {kind}
    assert result.causes[0]['times'] == pytest.approx(share, abs=0.01)
    check = next(check for check in result.checks if check.name == NAME)
    assert check.verdict == ('fail' if share > 1.0 else 'pass')


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
def test_a_whole_compensation_is_neither_over_nor_under(looped, seed):
    result = validate(looped(sim=noisy(seed, **FRICTION, **{
        'friction_compensation.viscous_scale': [1.0] * 6,
        'friction_compensation.coulomb_scale': [1.0] * 6})))
    assert not NEW.intersection(found(result))


@pytest.mark.thorough
@pytest.mark.parametrize('seed', SEEDS)
@pytest.mark.parametrize('sim', some([{}, FRICTION]))
def test_a_run_without_any_of_them_has_none(looped, sim, seed):
    assert not NEW.intersection(found(validate(looped(sim=noisy(seed, **sim)))))


@pytest.mark.parametrize('sim', [
    {'payload.mass': 1.0}, {'friction.viscous': sizes(2.0)}, {'friction.coulomb': sizes(2.0)},
    {'friction.viscous': sizes(2.0), 'friction.coulomb': sizes(1.0), 'payload.mass': 0.5}],
    ids=['payload', 'viscous', 'Coulomb', 'all three'])
def test_what_was_known_before_is_not_taken_for_what_is_new(looped, sim):
    assert not NEW.intersection(found(validate(looped(sim=noisy(1, **sim)))))


def test_stiction_is_found_beside_a_payload(looped):
    result = validate(looped(sim=noisy(1, **{
        'payload.mass': 1.0, 'friction.static': sizes(2.0),
        'friction.stribeck_velocity': [1e-3] * 6})))
    assert sorted(found(result)) == ['payload', 'stiction']


#: A hand that lightly holds the tool: stiffness [N/m], damping [N s/m], and its push [m].
STIFFNESS, DAMPING, PUSH = 400.0, 8.0, 0.05


def touched(temperature_factor, seconds=5.0, rate=500):
    """Return a run at zero torque in which a hand pushes the tool aside and holds it lightly."""
    parameters = {
        'arm': 'ur5e', 'control_rate': rate, 'physics_rate': 1000,
        'initial_positions': [0.0, -1.2, 1.6, -0.4, 0.0, 0.0], 'effort_convention':
        'gravity_excluded', 'delay.state_periods': 2,
        'friction_compensation.viscous_scale': [0.9, 0.9, 0.8, 0.9, 0.9, 0.9],
        'friction_compensation.coulomb_scale': [0.8, 0.8, 0.7, 0.8, 0.8, 0.8],
        'friction.temperature_factor': [temperature_factor] * 6}
    friction = load_arm('ur5e_real').friction
    parameters |= {f'friction.{part}': getattr(friction, part).tolist() for part in (
        'viscous', 'coulomb', 'viscous_quadratic', 'viscous_cubic', 'asymmetry')}
    arm = load_arm('ur5e')
    plant = Plant(arm, parameters)
    middle = forward_kinematics(plant.truth.q, arm)[1, 3]
    states, truths, events = [plant.state], [plant.truth], []
    for k in range(round(seconds * rate)):
        if k % 2:
            states.append(plant.step(np.zeros(6)))
            truths.append(plant.truth)
            continue
        q, qd = plant.truth.q, plant.truth.qd
        aside = PUSH if k < 0.5 * rate else 0.0
        force = (STIFFNESS * (middle + aside - forward_kinematics(q, arm)[1, 3])
                 - DAMPING * (jacobian(q, arm)[1] @ qd))
        plant.apply_wrench([0.0, force, 0.0], [0.0, 0.0, 0.0])
        states.append(plant.step(np.zeros(6)))
        truths.append(plant.truth)
        events += plant.drain_events()
    plant.close()
    seen, true = (States(*(np.array([getattr(each, part) for each in many])
                           for part in ('q', 'qd', 'effort'))) for many in (states, truths))
    return Run('touched', np.array([each.stamp for each in states]), seen, float(rate), 1000.0,
               true, sim=NodeRecord('ur5e', arm, plant.parameters.by_name()), events=tuple(
                   RecordedEvent(each.stamp, each.kind, each.message, {
                       key: json.loads(value) for key, value in each.values.items()})
                   for each in events))


def test_zero_torque_and_a_push_make_no_vibration_at_nominal_friction():
    run = touched(1.0)
    assert np.abs(run.truth.qd[1500:]).max() < 1e-9
    assert found(validate(run)) == ['state delay']


def test_a_warm_joint_vibrates_when_touched_and_the_report_names_it():
    run = touched(0.75)
    swing = np.abs(run.truth.qd[-500:, 0]).max()
    assert swing > 0.5 and np.abs(run.truth.qd[:, 1:]).max() < 1e-9
    result = validate(run)
    assert found(result) == ['over-compensation', 'state delay']
    cause = result.causes[0]
    assert 'limit cycle' in cause['sentence']
    assert cause['joints']['shoulder_pan_joint']['value'] == pytest.approx(0.85 / 0.75, rel=0.05)
    assert cause['limit_cycle']['joint'] == 'shoulder_pan_joint'
    print(cause['sentence'])
