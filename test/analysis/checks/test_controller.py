"""A user's own controller is judged by what it was asked to follow, or not at all."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.data.given_reference import given_reference
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import NodeRecord, Run, States
from ur5_ros.analysis.report.html import html_text
from ur5_ros.analysis.validate import validate
from ur5_ros.cli.terminal import number
from ur5_ros.config import SIM_PARAMETERS, complete, load_arm
from ur5_ros.config.friction import with_arm_friction
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.sim.plant import Plant

GOAL = np.array([0.3, -1.3, 1.3, -1.2, -1.5, 0.3])
STIFFNESS = np.array([100.0, 200.0, 100.0, 20.0, 20.0, 5.0])
JOINTS = ','.join(f'{q:g}' for q in GOAL)


def run_of(arm='ur5_real', damping=0.25, seconds=6.0, events=(), **parameters) -> Run:
    """Return a run of a plain PD law to one goal, as the simulator's bag alone would hold it."""
    parameters = {'effort_convention': 'gravity_excluded', **parameters}
    plant = Plant(load_arm(arm), parameters)
    states, commands = [plant.state], []
    try:
        for _ in range(round(seconds * 1000)):
            state = states[-1]
            commands.append(STIFFNESS * (GOAL - state.q) - damping * STIFFNESS * state.qd)
            states.append(plant.step(commands[-1]))
    finally:
        plant.close()
    commands.append(commands[-1])
    return Run('pd', np.array([state.stamp for state in states]),
               States(*(np.array([state[i] for state in states]) for i in (1, 2, 3))), 1000.0,
               1000.0, command=np.array(commands), events=tuple(events), sim=NodeRecord(
                   arm, load_arm(arm), complete(SIM_PARAMETERS, {'arm': arm, **parameters})))


def judged(run: Run, text: str = JOINTS):
    return validate(replace(run, reference=given_reference(run, text)))


@pytest.fixture(scope='module')
def good():
    return run_of()


@pytest.fixture(scope='module')
def sagging():
    return run_of(effort_convention='total')


def test_without_a_reference_the_verdict_is_only_of_the_simulation(sagging):
    result = validate(sagging)
    assert result.passed and not result.controller_judged
    assert result.headline == 'simulation consistent; controller not judged'
    assert '--reference' in result.check('controller').sentence


def test_a_law_that_sags_fails_as_soon_as_the_goal_is_known(sagging):
    result = judged(sagging)
    check = result.check('controller tracking')
    assert not result.passed and check.verdict == 'fail'
    sag = np.abs(sagging.states.q[-1] - GOAL).max()
    assert check.value >= sag > 0.05
    assert 'rest beside it: a law without a gravity term holds gravity' in check.sentence
    settling = result.check('controller settling')
    assert settling.verdict == 'fail' and 'not settled within' in settling.sentence
    assert number(settling.value) == 'never' and '>never<' in html_text(result)


def test_a_law_that_reaches_its_goal_passes(good):
    result = judged(good)
    assert result.headline == 'pass'
    assert {check.verdict for check in result.checks if check.name.startswith('controller')} == {
        'pass'}
    assert 0.1 < result.check('controller settling').value < 2.0


def test_joints_that_friction_holds_beside_their_goal_are_named(good):
    held = run_of(**{'friction.coulomb': [0.0, 0.0, 5.0, 0.0, 0.0, 0.0]})
    stands = np.abs(held.states.qd[-1]) < 1e-9
    assert np.flatnonzero(stands & (np.abs(held.states.q[-1] - GOAL) > 0.02)).tolist() == [2]
    sentence = judged(held).check('controller tracking').sentence
    assert sentence.endswith('; at the end friction holds elbow_joint beside the reference')
    assert 'friction' not in judged(good).check('controller tracking').sentence


def test_the_settling_time_is_when_the_error_last_left_the_band(good):
    error = np.abs(good.states.q - GOAL).max(axis=1)
    last = np.flatnonzero(error > 0.02)[-1]
    assert judged(good).check('controller settling').value == pytest.approx((last + 1) * 1e-3)


def test_an_excursion_beyond_the_goal_is_an_overshoot():
    loose = judged(run_of(damping=0.03, seconds=3.0))
    assert loose.check('controller overshoot').verdict == 'fail'
    assert loose.check('controller overshoot').value > 0.1


def test_the_pose_of_the_goal_serves_as_well_as_its_joints(good):
    arm = load_arm('ur5_real')
    pose = forward_kinematics(GOAL, arm)
    text = ','.join(f'{x:.12g}' for x in (*pose[:3, 3], *quaternion_of(pose[:3, :3])))
    reference = given_reference(good, text)
    np.testing.assert_allclose(reference.q, np.broadcast_to(GOAL, reference.q.shape), atol=1e-9)


def test_an_experiment_and_a_topic_give_the_reference_that_was_recorded(recorded):
    run = load_run(recorded)
    for text in ('kebria_fig11', '/ur5_control/reference'):
        again = load_run(recorded, reference=text)
        for part, other in zip(run.reference, again.reference, strict=True):
            np.testing.assert_allclose(part, other, atol=1e-12)


@pytest.mark.parametrize(('text', 'words'), [
    ('nonsense', 'six joint angles'), ('1,2,3', 'six joint angles'),
    ('1,2,3,4,5,nan', 'six joint angles'), ('0,0,9,0,0,0,1', 'out of reach'),
    ('0,0,0.5,0,0,0,2', 'norm'), ('/nothing', 'no such topic'),
])
def test_a_reference_that_is_none_is_refused_with_the_way_out(recorded, text, words):
    with pytest.raises(InputError, match=words):
        load_run(recorded, reference=text)


def test_a_loop_that_is_unstable_when_sampled_is_named_with_its_joint_and_way_out():
    result = validate(run_of('ur5', seconds=1.0))
    check = result.check('controller stability')
    assert check.verdict == 'fail' and check.details['joint'].startswith('wrist')
    cause = next(each for each in result.causes if each['kind'] == 'unstable when sampled')
    assert cause['joint'] == check.details['joint']
    calm = run_of('ur5', damping=0.5 * cause['largest_damping'] / STIFFNESS.max(), seconds=1.0)
    assert validate(calm).check('controller stability').verdict == 'pass'


def test_what_is_added_to_the_plant_is_named():
    run = run_of(seconds=0.5, **{'payload.mass': 2.0, 'noise.velocity': 0.001})
    added = [each['what'] for each in validate(run).about['injected']]
    assert added == ['payload.mass 2', 'noise.velocity 0.001']


def test_friction_of_the_arms_file_is_named_in_a_word():
    given = {'friction.from_arm': True, 'friction.temperature_factor': [0.75] * 6}
    run = run_of('ur5e_real', seconds=0.01, **given)
    from_file = with_arm_friction(SimParameters.of(run.sim.parameters), run.sim.arm.friction)
    run = replace(run, sim=replace(run.sim, parameters=from_file.by_name()))
    added = [each['what'] for each in validate(run).about['injected']]
    assert added == ['friction of ur5e_real', 'friction.temperature_factor 0.75']
