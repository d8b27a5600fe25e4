"""Energy gained is work done: to the second order of the time step, whatever length and rate."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.energy import balance
from ur5_ros.analysis.plant_integrator import friction_step, plant_models
from ur5_ros.analysis.validate import validate
from ur5_ros.sim.friction import solve_friction

FRICTION = {'friction.viscous': [2.0, 2.0, 2.0, 0.5, 0.5, 0.5],
            'friction.coulomb': [3.0, 3.0, 3.0, 0.4, 0.4, 0.4], 'payload.mass': 1.5}
STICKY = {'friction.viscous': [0.1] * 6, 'friction.coulomb': [5.0] * 3 + [1.0] * 3}


def energies(result):
    return [result.check(name) for name in ('energy balance', 'passivity')]


@pytest.mark.parametrize('seconds', [0.5, 1.0, 2.0, 20.0])
@pytest.mark.parametrize('rate', [250, 1000, 4000])
def test_clean_runs_of_any_length_and_rate_keep_the_balance(looped, rate, seconds):
    run = looped('kebria_fig11', 'ur5', seconds, control_rate=rate, physics_rate=rate)
    for check in energies(validate(run)):
        assert check.verdict == 'pass', check.sentence
        assert check.value <= 0.3 * check.limit  # the scheme's own quarter, and little else
        assert check.limit < 1e-4 * check.details['moved_J'] * (1000 / rate)**2


@pytest.mark.parametrize('sim', [{}, FRICTION, STICKY], ids=['clean', 'friction', 'sticky'])
@pytest.mark.parametrize('rates', [(1000, 1000), (250, 250), (250, 1000), (100, 1000)])
@pytest.mark.parametrize('experiment', ['kebria_fig11', 'joint_step', 'exciting'])
def test_friction_payload_and_held_torques_keep_it_as_well(looped, experiment, rates, sim):
    run = looped(experiment, 'ur5', 2.0, sim=sim, control_rate=rates[0], physics_rate=rates[1])
    found = balance(run, plant_models(run))
    assert np.abs(np.cumsum(found.surplus)).max() <= 0.3 * found.discretisation + 1e-9


def test_what_the_scheme_misses_falls_with_the_square_of_the_step(looped):
    missed = []
    for rate in (250, 1000, 4000):
        run = looped('exciting', 'ur5_real', 2.0, control_rate=rate, physics_rate=rate)
        missed.append(np.abs(np.cumsum(balance(run, plant_models(run)).surplus)).max())
    for coarse, fine in zip(missed[:-1], missed[1:], strict=True):
        assert coarse / fine == pytest.approx(16.0, rel=0.1)


@pytest.mark.parametrize('seconds', [0.5, 2.0])
@pytest.mark.parametrize('part', [1.0 + 1e-3, 1.0 - 1e-3])
def test_a_thousandth_of_the_work_from_nowhere_or_lost_is_noticed(looped, part, seconds):
    run = looped('kebria_fig11', 'ur5', seconds)
    wrong = replace(run, states=run.states._replace(effort=run.states.effort * part))
    check = validate(wrong).check('energy balance')
    assert check.verdict == 'fail' and check.value > 50 * check.limit


def test_the_balance_holds_across_a_change_of_the_plant(stepped):
    def meddle(k, plant, torque):
        if k == 200:
            plant.change('payload.mass', 2.0)
        if k == 300:
            plant.apply_wrench([10.0, 0.0, -5.0], [0.5, 0.0, 1.0])
        return torque
    for check in energies(validate(stepped(meddle))):
        assert check.verdict == 'pass' and check.details['moved_J'] > 0.0


def test_a_gap_is_left_out_of_the_balance(looped):
    run = looped('kebria_fig11', 'ur5', 1.0)
    keep = np.r_[0:300, 340:len(run.stamp)]
    parts = {'stamp': run.stamp[keep], 'command': run.command[keep],
             'states': type(run.states)(*(part[keep] for part in run.states)),
             'reference': type(run.reference)(*(part[keep] for part in run.reference)),
             'parts': {}}
    for check in energies(validate(replace(run, **parts))):
        assert check.verdict == 'pass', check.sentence


def test_sticking_is_solved_as_the_simulator_solves_it():
    random = np.random.default_rng(7)
    lever = random.normal(size=(300, 6, 6)) * np.array([30, 30, 10, 1, 0.1, 0.03])[:, None]
    A = lever @ np.swapaxes(lever, 1, 2) * 1000.0 + 1e-3 * np.eye(6)
    drive, qd = random.normal(size=(300, 6)) * 50.0, random.normal(size=(300, 6)) * 1e-3
    level = np.abs(random.normal(size=6)) * [30, 30, 30, 3, 3, 0]
    found = friction_step(A, drive, qd, level)
    free = np.full(6, np.inf)
    for row in range(300):
        expected, _ = solve_friction(A[row], drive[row], qd[row], level, -free, free)
        np.testing.assert_allclose(qd[row] + found[row], qd[row] + expected, rtol=1e-6, atol=1e-9)
