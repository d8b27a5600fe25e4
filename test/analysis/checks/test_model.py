"""Model and plant agree to rounding, and a wrong model fails with the joint named."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.model import localize_fault
from ur5_ros.analysis.data.run import RecordedEvent
from ur5_ros.analysis.plant_integrator import PlantModel, plant_models
from ur5_ros.analysis.residual import residual
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.signals import JOINT_NAMES


def test_a_clean_run_passes_every_check(clean_run):
    result = validate(clean_run)
    assert result.verdict == 'pass', [c.sentence for c in result.checks if c.verdict == 'fail']
    assert result.check('residual, controller arm').value < 1e-9
    assert result.causes == ()


@pytest.mark.parametrize('experiment', ['kebria_fig11', 'exciting', 'cartesian_circle'])
def test_pybullet_moves_as_the_equations_say(looped, experiment):
    run = looped(experiment, 'ur5', duration=2.0)
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('error step').value < 1e-12


@pytest.mark.parametrize('rate', [1000, 250])
def test_the_residual_is_exact_with_friction_payload_and_other_gravity(looped, rate):
    run = looped(duration=2.0, control_rate=rate, sim={
        'friction.viscous': [2.0, 2.0, 2.0, 0.5, 0.5, 0.5], 'payload.com': [0.01, 0.02, 0.05],
        'friction.coulomb': [3.0, 3.0, 3.0, 0.4, 0.4, 0.4], 'payload.mass': 1.5,
        'gravity': [0.5, 0.0, -9.7]})
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('residual, controller arm').value > 1.0


def test_the_exact_states_are_judged_where_noise_is_on(looped):
    run = looped(duration=2.0, sim={'noise.velocity': 1e-3, 'noise.position': 1e-4})
    assert validate(run).check('residual, simulator arm').value < 1e-9


@pytest.mark.parametrize('link, joint, name', [
    (1, 'shoulder_lift_joint', 'upper arm'), (2, 'elbow_joint', 'forearm'),
    (3, 'wrist_1_joint', 'wrist 1')])
def test_a_wrong_mass_fails_and_names_the_outermost_joint(simulated, link, joint, name):
    arm = load_arm('ur5')
    mass = arm.mass.copy()
    mass[link] *= 1.02
    result = validate(simulated(seconds=0.5, plant=replace(arm, mass=mass)))
    check = result.check('residual, controller arm')
    assert result.verdict == 'fail' and check.verdict == 'fail'
    assert f'outermost is {joint}, so check the {name}' in check.sentence
    assert check.details['joint'] in JOINT_NAMES


def test_a_parameter_changed_during_the_run_acts_from_its_stamp_on(simulated):
    run = simulated(seconds=0.2)
    row = 100
    event = RecordedEvent(int(run.stamp[row]), 'parameter', '', {'name': 'gravity',
                                                                 'value': [0, 0, 0]})
    plan = plant_models(replace(run, events=(event,)))
    assert [first for first, _ in plan] == [0, row]
    found = residual(replace(run, events=(event,)), plan).torque
    assert np.abs(found[:row]).max() < 1e-9 < np.abs(found[row:]).max()


def test_the_step_across_a_reset_is_left_out(simulated):
    run = simulated(seconds=0.2)
    states = run.states._replace(q=run.states.q.copy())
    states.q[120:] += 0.5
    event = RecordedEvent(int(run.stamp[120]), 'reset', '', {})
    broken = replace(run, states=states, events=(event,))
    assert np.isnan(residual(broken, [(0, PlantModel(run.sim.arm))]).torque[119]).all()


def test_another_torque_than_commanded_is_noticed(simulated):
    run = simulated(seconds=0.2)
    command = run.command.copy()
    command[50, 2] += 1e-3
    check = validate(replace(run, command=command)).check('command acts')
    assert check.verdict == 'fail' and 'elbow_joint' in check.sentence
    assert check.details['differing'] == 1


def test_the_fallback_is_named_where_it_acted_in_place_of_the_command(simulated):
    run = simulated(seconds=0.2)
    command = run.command.copy()
    command[[20, 60, 61], 2] += 1e-3
    stamp = int(run.stamp[50])
    events = (RecordedEvent(stamp, 'protective_stop', '', {}),
              RecordedEvent(stamp, 'fallback', '', {'mode': 'brake', 'active': True}))
    sentence = validate(replace(run, command=command, events=events)).check(
        'command acts').sentence
    assert sentence.startswith('in 3 of 200 periods another torque acted')
    assert sentence.endswith('in 2 of them that of the fallback (brake), from 0.06 s on, after a '
                             'protective stop')


def test_limits_touched_are_named(simulated):
    run = simulated(seconds=0.2)
    states = run.states._replace(qd=run.states.qd.copy())
    states.qd[10, 4] = -3.2
    check = validate(replace(run, states=states)).check('limits')
    assert check.verdict == 'fail' and 'wrist_2_joint speed in 1 state ' in check.sentence


def test_energy_from_nowhere_is_noticed(simulated):
    run = simulated(seconds=1.0)
    states = run.states._replace(effort=run.states.effort * 0.9)
    result = validate(replace(run, states=states, command=run.command * 0.9))
    assert result.check('energy balance').verdict == 'fail'


def test_commands_that_are_not_the_laws_are_noticed(simulated):
    run = simulated(seconds=0.4)
    assert validate(run).check('law').value < 1e-9
    reported = replace(run.control, parameters={**run.control.parameters, 'kd': [11.0]})
    check = validate(replace(run, control=reported)).check('law')
    assert check.verdict == 'fail' and 'another law answered' in check.sentence


def test_a_residual_that_is_no_number_names_no_joint():
    assert 'no joint is beyond' in localize_fault(np.zeros(6, dtype=bool))
