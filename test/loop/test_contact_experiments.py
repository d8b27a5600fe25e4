"""The experiments with contact: the books balance on every plant, and the figures come out."""

import numpy as np
import pytest
from thorough import times

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.result import FAIL
from ur5_ros.analysis.validate import validate
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config

EXPERIMENTS = ('press_and_slide', 'push_block', 'tap_wall', 'peg_in_hole')
FRICTION = {'friction.coulomb': [2.0, 2.0, 1.0, 0.5, 0.5, 0.3],
            'friction.viscous': [1.0, 1.0, 1.0, 0.2, 0.2, 0.2]}
#: Arm, further parameters of the plant, physics steps a second.
PLANTS = [('ur5', {}, 1000), ('ur5', {}, 4000), ('ur5_real', FRICTION, 1000),
          ('ur5_real', FRICTION, 4000)]
#: Experiment, arm, parameters, physics rate, simulated time [s].
CASES = times([('tap_wall', 'ur5', {}, 1000, 1.2),
               ('push_block', 'ur5_real', FRICTION, 4000, 1.6)],
              [(name, *plant, None) for name in EXPERIMENTS for plant in PLANTS])


def verdict_of(experiment, arm, sim, physics_rate, duration=None, folder=None, control=None):
    """Return the checks of a run, by name; from its bags where a folder is given."""
    run = run_closed_loop(run_config(experiment, arm, physics_rate=physics_rate, sim=sim,
                                     duration=duration, control=control), folder)
    return {check.name: check for check in validate(
        as_run(run) if folder is None else load_run(folder)).checks}


def contact_of(checks):
    return checks['residual, simulator arm'].value, checks['Coulomb cone'].verdict


@pytest.mark.thorough
@pytest.mark.parametrize(('experiment', 'arm', 'sim', 'physics_rate', 'duration'), CASES)
def test_the_books_balance_through_impact_sliding_and_friction(
        experiment, arm, sim, physics_rate, duration, record_property):
    checks = verdict_of(experiment, arm, sim, physics_rate, duration)
    residual, cone = contact_of(checks)
    record_property('residual [N m]', residual)
    for name, check in checks.items():
        if 'figure' in check.details:
            record_property(name, check.details['figure'])
    assert residual < 1e-9
    assert cone == 'pass'
    assert checks['energy balance'].verdict == 'pass'
    if not sim:
        assert not [check.sentence for check in checks.values() if check.verdict == FAIL]


RUBBING = times([('tap_wall', 4.1), ('push_block', None)], [(name, None) for name in EXPERIMENTS])


@pytest.mark.thorough
@pytest.mark.parametrize(('experiment', 'duration'), RUBBING)
def test_the_figures_hold_with_the_friction_of_a_real_arm_where_the_law_knows_it(
        experiment, duration, record_property):
    checks = verdict_of(experiment, 'ur5_real', {'friction.from_arm': True}, 1000, duration,
                        control={'friction_feedforward': True})
    assert not [check.sentence for check in checks.values() if check.verdict == FAIL]
    assert checks['residual, simulator arm'].value < 1e-9
    figures = {name: check for name, check in checks.items() if 'figure' in check.details}
    assert len(figures) >= 1
    for name, check in figures.items():
        record_property(name, check.sentence)
        allowed = check.details['friction_allowance']
        assert (allowed > 0.0) == (name == 'stiffness' or name == 'normal force'), name
        if name == 'stiffness':  # friction at rest holds up to 40 % of these forces
            assert 'that friction of joints at rest may hold' in check.sentence


def test_friction_that_the_law_does_not_know_moves_the_figures_and_they_fail():
    checks = verdict_of('push_block', 'ur5_real', {'friction.from_arm': True}, 1000)
    assert checks['way of the block'].verdict == FAIL


def test_the_bags_record_of_contact_what_the_loop_knows(tmp_path):
    plan = run_config('push_block', duration=1.6, physics_rate=4000)
    run = run_closed_loop(plan, tmp_path / 'push')
    recorded, known = load_run(tmp_path / 'push'), as_run(run)
    assert recorded.contact.any()
    assert np.array_equal(recorded.contact, known.contact)
    assert recorded.sim.world == known.sim.world
    assert len(recorded.objects) == len(known.objects) == 81
    assert all(a[0] == b[0] and np.array_equal(a[1], b[1]) for a, b in zip(
        recorded.objects, known.objects, strict=True))
    assert len(recorded.contact_forces) == len(known.contact_forces)


def test_a_pressed_spring_holds_stiffness_times_depth_and_a_wrench_what_was_asked():
    checks = verdict_of('tap_wall', 'ur5', {}, 1000, 4.1)
    assert checks['stiffness'].verdict == 'pass'
    assert checks['stiffness'].details['figure'] == pytest.approx(1000.0, rel=1e-3)
    assert checks['speed at the wall'].verdict == 'pass'
    assert checks['external torque'].value < 0.02


def test_two_runs_through_contact_give_the_same_bits():
    one, other = (run_closed_loop(run_config('tap_wall', duration=1.0)) for _ in range(2))
    assert one.contact.any()
    assert one.q.tobytes() == other.q.tobytes()
    assert one.contact.tobytes() == other.contact.tobytes()
    assert one.reports == other.reports


def test_contact_torque_left_out_is_named_with_the_bodies():
    run = as_run(run_closed_loop(run_config('tap_wall', duration=1.2)))
    run.contact[900:] = 0.0
    result = validate(run)
    cause, = result.causes
    assert not result.passed
    assert cause['kind'] == 'contact'
    assert cause['bodies'] == ['wrist_3_link', 'wall']
    assert 'wrist_3_link and wall touch' in cause['sentence']
    assert cause['force'] > 10.0
