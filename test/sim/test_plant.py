"""The plant's manners: time, effort, limits, changes, and the same bits for the same commands."""

import hashlib
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.config import SIM_PARAMETERS, complete, load_arm
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES, stamp_of_period
from ur5_ros.sim.payload import loaded_arm
from ur5_ros.sim.plant import Plant

ZERO = np.zeros(6)

#: A run with everything that a plant can do; prints the hash of all that it told.
RESTLESS = """
import hashlib, numpy as np
from ur5_ros.config import SIM_PARAMETERS, complete
from ur5_ros.sim.plant import plant_from_parameters
def restless(arm):
    plant = plant_from_parameters(complete(SIM_PARAMETERS, {
        'arm': arm, 'control_rate': 500, 'noise.position': 1e-4, 'noise.velocity': 1e-3,
        'delay.state_periods': 2, 'delay.command_periods': 1, 'seed': 7}))
    rng, told = np.random.default_rng(3), hashlib.sha256()
    changes = {50: ('friction.viscous', [3.0] * 6), 80: ('friction.coulomb', [0.5] * 6),
               120: ('payload.mass', 1.5), 150: ('gravity', [1.0, 2.0, -9.0]),
               180: ('delay.command_periods', 0), 200: ('seed', 8), 260: ('payload.mass', 0.0)}
    for step in range(400):
        if step in changes:
            plant.change(*changes[step])
        if step == 220:
            plant.apply_wrench([5.0, 0.0, 3.0], [0.0, 1.0, 0.0])
        if step == 300:
            plant.reset()
        state = plant.step(None if step % 40 > 30 else rng.normal(size=6) * [9, 60, 30, 4, 2, .1])
        for part in (state, plant.truth):
            told.update(np.array([part.stamp, *part.q, *part.qd, *part.effort]).tobytes())
    told.update(repr(plant.drain_events()).encode())
    plant.close()
    return told.hexdigest()
"""


def test_the_same_commands_give_the_same_bits_in_one_process_and_in_two():
    scope = {}
    exec(RESTLESS, scope)
    for arm in ('ur5', 'ur5_real'):
        here = [scope['restless'](arm) for _ in range(2)]
        there = subprocess.run(
            [sys.executable, '-c', f'{RESTLESS}\nprint(restless({arm!r}))'], check=True,
            capture_output=True, text=True, timeout=120).stdout.strip()
        assert here == [there, there]


def test_two_plants_do_not_feel_each_other(plant_of):
    alone = plant_of()
    pairs = plant_of(), plant_of(arm='ur10e')
    for _ in range(100):
        expected = alone.step(ZERO)
        pairs[1].step(ZERO)
        state = pairs[0].step(ZERO)
        np.testing.assert_array_equal(state.q, expected.q)
        np.testing.assert_array_equal(state.qd, expected.qd)


def test_time_is_an_integer_and_state_one_has_no_effort(plant_of):
    plant = plant_of(control_rate=300, physics_rate=900)
    assert plant.k == 1 and not plant.state.effort.any()
    for k in range(1, 10):
        assert plant.state.stamp == stamp_of_period(k, 300)
        command = np.full(6, float(k))
        np.testing.assert_array_equal(plant.step(command).effort, command)
        assert plant.k == k + 1


def test_what_the_plant_returned_does_not_change_afterwards(plant_of):
    plant = plant_of()
    command = np.ones(6)
    state = plant.step(command)
    kept = [part.copy() for part in state[1:]]
    command[:] = 99.0
    plant.step(-command / 9.0)
    for now, then in zip(state[1:], kept, strict=True):
        np.testing.assert_array_equal(now, then)


@pytest.mark.fault(1, 2, 5)
@pytest.mark.parametrize('wrong', [[0.0] * 5, [0.0] * 7, [np.nan] + [0.0] * 5,
                                   [np.inf] + [0.0] * 5, np.zeros((1, 6)), []])
def test_a_command_that_is_not_six_finite_numbers_changes_nothing(plant_of, wrong):
    plant = plant_of()
    before = plant.truth
    with pytest.raises(InputError, match='six finite'):
        plant.step(wrong)
    assert plant.k == 1 and plant.truth is before
    assert not plant.drain_events()


@pytest.mark.fault(1, 2, 3)
def test_of_fuzzed_commands_none_reaches_the_engine_beyond_the_limits(monkeypatch):
    arm = load_arm('ur5')  # without stops, which hold with whatever it takes
    plant = Plant(replace(arm, limits=replace(arm.limits, lower=np.full(6, -np.inf),
                                              upper=np.full(6, np.inf))),
                  complete(SIM_PARAMETERS, {}))
    limit, bullet = plant.arm.limits.effort, plant.mechanics.bullet
    advance, applied = bullet.advance, []
    monkeypatch.setattr(bullet, 'advance', lambda tau: (applied.append(tau), advance(tau))[1])
    rng = np.random.default_rng(51)
    bad = [np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, -0.0]
    refused = 0
    for _ in range(20_000):
        command = rng.normal(size=6) * 10.0 ** rng.uniform(-300.0, 300.0, 6)
        if rng.random() < 0.5:
            command[rng.integers(6)] = rng.choice(bad)
        try:
            state = plant.step(command)
        except InputError:
            refused += 1
            continue
        assert np.isfinite(state.q).all() and np.isfinite(state.qd).all()
        if plant.stopped or not plant.k % 50:
            plant.reset()
        assert (np.abs(state.effort) <= limit).all()
    plant.close()
    assert refused > 1000 and len(applied) == 20_000 - refused
    assert (np.abs(applied) <= limit).all()


@pytest.mark.fault(3)
def test_torque_is_clamped_to_the_limits_and_flagged_once_each_way(plant_of):
    plant = plant_of()
    limit = plant.arm.limits.effort
    for command in (1e30 * np.ones(6), 1e300 * np.ones(6), limit + 1.0):
        np.testing.assert_array_equal(plant.step(command).effort, limit)
    plant.reset()
    plant.step(ZERO)
    reported = [(json.loads(event.values['active']), json.loads(event.values['joints']))
            for event in plant.drain_events()
            if event.kind == 'limit' and json.loads(event.values['kind']) == 'effort']
    assert reported == [(True, list(JOINT_NAMES)), (False, [])]


@pytest.mark.fault(64)
def test_a_state_that_diverges_is_put_back_at_rest_and_never_published(plant_of, monkeypatch):
    plant = plant_of()
    plant.step(ZERO)
    q = plant.truth.q
    advance = plant.mechanics.bullet.advance
    monkeypatch.setattr(plant.mechanics.bullet, 'advance', lambda tau: advance([1e308] * 6))
    state = plant.step(ZERO)
    monkeypatch.undo()
    np.testing.assert_array_equal(state.q, q)
    assert not state.qd.any() and plant.stopped
    assert 'ran away' in [event for event in plant.drain_events()
                          if event.kind == 'protective_stop'][0].message
    for _ in range(100):
        assert np.abs(plant.step(ZERO).qd).max() < 1e-9, 'the brake holds'
    plant.reset()
    assert not plant.stopped and np.isfinite(plant.step(ZERO).q).all()


def test_over_speed_is_flagged_and_stops_the_run_only_when_asked(plant_of):
    for asked in (False, True):
        plant = plant_of(overspeed_stop=asked, gravity=[0.0, 0.0, 0.0])
        push = np.array([20.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        for _ in range(600):
            state = plant.step(push)
        flags = [event for event in plant.drain_events() if event.kind == 'limit'
                 and json.loads(event.values['kind']) == 'velocity']
        assert json.loads(flags[0].values['joints']) and json.loads(flags[0].values['active'])
        assert plant.stopped is asked
        if asked:
            assert np.abs(state.qd).max() < 1e-9
            assert plant.counters['protective_stops'] == 1
            plant.reset()
            assert not plant.stopped
        else:
            assert np.abs(state.qd).max() > np.pi


def test_a_stop_holds_a_joint_exactly_and_lets_it_go(plant_of):
    plant = plant_of(initial_positions=[6.2, -1.5, 0.0, 0.0, 0.0, 0.0], gravity=[0.0, 0.0, 0.0])
    upper = plant.arm.limits.upper[0]
    for _ in range(500):
        assert plant.step(np.array([30.0, 0, 0, 0, 0, 0])).q[0] <= upper + 1e-12
    assert abs(plant.truth.q[0] - upper) < 1e-12
    assert abs(plant.truth.qd[0]) < 1e-12
    for _ in range(100):
        plant.step(np.array([-30.0, 0, 0, 0, 0, 0]))
    assert plant.truth.q[0] < upper - 0.01
    reported = [(json.loads(event.values['joints']), json.loads(event.values['active']))
            for event in plant.drain_events() if event.kind == 'limit'
            and json.loads(event.values['kind']) == 'position']
    assert reported == [(['shoulder_pan_joint'], True), ([], False)]


def test_a_reset_is_the_initial_state_under_the_next_stamp(plant_of):
    plant = plant_of(initial_velocities=[0.1] * 6, delay__state_periods=3)
    first = plant.truth
    for _ in range(10):
        plant.step(np.full(6, 5.0))
    state = plant.reset()
    assert plant.k == 12 and state.stamp == stamp_of_period(12, 1000)
    np.testing.assert_array_equal(state.q, first.q)
    np.testing.assert_array_equal(plant.truth.qd, first.qd)
    assert not state.effort.any()
    event = plant.drain_events()[-1]
    assert event.kind == 'reset' and event.stamp == state.stamp
    assert json.loads(event.values['position']) == first.q.tolist()


def test_a_run_after_a_reset_is_the_first_run_again(plant_of):
    plant = plant_of(arm='ur5_real')
    runs = []
    for _ in range(2):
        reported = hashlib.sha256()
        for step in range(200):
            state = plant.step(np.sin(step * np.arange(6)) * 5.0)
            reported.update(state.q.tobytes() + state.qd.tobytes())
        runs.append(reported.digest())
        plant.reset()
    assert runs[0] == runs[1]


def test_changes_act_from_the_next_step_and_are_events(plant_of):
    plant, other = plant_of(), plant_of(payload__mass=2.0, payload__com=[0.0, 0.0, 0.1])
    plant.change('payload.com', [0.0, 0.0, 0.1])
    plant.change('payload.mass', 2)
    for _ in range(50):
        np.testing.assert_array_equal(plant.step(ZERO).q, other.step(ZERO).q)
    reported = [(event.stamp, json.loads(event.values['name']), json.loads(event.values['value']))
            for event in plant.drain_events() if event.kind == 'parameter']
    assert reported == [(1_000_000, 'payload.com', [0.0, 0.0, 0.1]),
                        (1_000_000, 'payload.mass', 2.0)]


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('payload.mass', -1.0, 'give'), ('payload.mass', float('nan'), 'finite'),
    ('payload.mass', 'heavy', 'number'), ('friction.viscous', [1.0] * 5, '5 numbers'),
    ('friction.coulomb', [-1.0] * 6, 'give'), ('gravity', [0.0, 0.0], '2 numbers'),
    ('noise.position', 2.0, 'give'), ('delay.state_periods', 1.5, 'whole'),
    ('control_rate', 500, 'cannot change'), ('wings', 2, 'is no parameter'),
    ('fallback', 'pray', 'one of'),
])
def test_a_change_out_of_range_is_refused_and_changes_nothing(plant_of, name, value, reason):
    plant = plant_of()
    before = plant.parameters
    with pytest.raises(InputError, match=reason):
        plant.change(name, value)
    assert plant.parameters == before and not plant.drain_events()


@pytest.mark.fault(33, 40)
@pytest.mark.parametrize(('given', 'reason'), [
    ({'control_rate': 300}, 'use 250 or 500'),
    ({'arm': 'ur5_controller'}, 'point mass'),
    ({'initial_positions': [7.0, 0, 0, 0, 0, 0]}, 'shoulder_pan_joint 7 rad is beyond a stop'),
])
def test_a_plant_that_cannot_be_is_refused_with_the_way_out(plant_of, given, reason):
    with pytest.raises(InputError, match=reason):
        plant_of(**given)


def test_gravity_excluded_adds_the_gravity_of_the_record_not_of_the_payload(plant_of, witness_of):
    for extra in ({}, {'payload__mass': 2.0, 'payload__com': [0.0, 0.03, 0.05]},
                  {'gravity': [1.0, 2.0, -9.0], 'payload__mass': 1.0}):
        plant = plant_of(effort_convention='gravity_excluded', **extra)
        witness = witness_of(load_arm('ur5'))
        for step in range(30):
            q, command = plant.truth.q, np.full(6, 0.01 * step)
            expected = command + witness.bias(q, ZERO)
            np.testing.assert_allclose(plant.step(command).effort, expected, atol=1e-11)


def test_zeros_hold_the_pose_when_gravity_is_excluded(plant_of):
    plant = plant_of(arm='ur5_real', effort_convention='gravity_excluded')
    start = plant.truth.q
    for _ in range(1000):
        plant.step(ZERO)
    assert np.abs(plant.truth.q - start).max() < 1e-6


def test_limits_act_on_the_sum_when_gravity_is_excluded(plant_of):
    plant = plant_of(effort_convention='gravity_excluded')
    limit = plant.arm.limits.effort
    np.testing.assert_array_equal(plant.step(limit * 3.0).effort, limit)


@pytest.mark.parametrize('delay', [1, 2, 7])
def test_a_delayed_command_acts_that_many_periods_later(plant_of, delay):
    plant = plant_of(delay__command_periods=delay)
    for k in range(1, 30):
        state = plant.step(np.full(6, 0.1 * k))
        if k <= delay:
            assert np.abs(state.effort).max() > 1.0, 'the brake before any arrives'
        else:
            np.testing.assert_array_equal(state.effort, np.full(6, 0.1 * (k - delay)))


def test_a_delay_that_grows_keeps_the_last_command_until_the_next_arrives(plant_of):
    plant = plant_of()
    plant.step(np.full(6, 0.1))
    plant.change('delay.command_periods', 3)
    efforts = [plant.step(np.full(6, 0.2))[3][0] for _ in range(5)]
    np.testing.assert_array_equal(efforts, [0.1, 0.1, 0.1, 0.2, 0.2])
    assert plant.counters['fallback_periods'] == 0


@pytest.mark.parametrize('delay', [1, 3, 50])
def test_a_delayed_state_has_todays_stamp_and_yesterdays_content(plant_of, delay):
    plant = plant_of(delay__state_periods=delay)
    truths = [plant.truth]
    for _ in range(100):
        state = plant.step(ZERO)
        truths.append(plant.truth)
        content = truths[max(0, len(truths) - 1 - delay)]
        assert state.stamp == plant.truth.stamp
        for now, then in zip(state[1:], content[1:], strict=True):
            np.testing.assert_array_equal(now, then)


def test_noise_has_its_size_is_white_and_does_not_touch_the_truth(plant_of):
    silent = plant_of(fallback='gravity_compensation')
    noisy = plant_of(fallback='gravity_compensation', noise__position=1e-3, noise__velocity=2e-2)
    errors = []
    for _ in range(4000):
        state, truth = noisy.step(None), silent.step(None)
        np.testing.assert_array_equal(noisy.truth.q, truth.q)
        errors.append(np.concatenate([(state.q - truth.q) / 1e-3, (state.qd - truth.qd) / 2e-2]))
    errors = np.array(errors)
    assert np.abs(errors.mean(axis=0)).max() < 5.0 / np.sqrt(4000)
    assert np.abs(errors.std(axis=0) - 1.0).max() < 5.0 / np.sqrt(8000)
    assert np.abs(np.corrcoef(errors.T) - np.eye(12)).max() < 6.0 / np.sqrt(4000)
    assert np.abs((errors[1:] * errors[:-1]).mean(axis=0)).max() < 5.0 / np.sqrt(4000)


def test_noise_depends_only_on_seed_and_period(plant_of):
    always = plant_of(noise__position=1e-3, seed=5)
    late = plant_of(seed=5)
    for step in range(50):
        if step == 30:
            late.change('noise.position', 1e-3)
        a, b = always.step(None), late.step(None)
    np.testing.assert_array_equal(a.q, b.q)
    other = plant_of(noise__position=1e-3, seed=6)
    for _ in range(50):
        c = other.step(None)
    assert (a.q != c.q).all()


def test_a_wrench_lasts_as_long_as_it_should(plant_of):
    plant = plant_of(arm='ur5_real', fallback='gravity_compensation', wrench_duration=0.05)
    plant.step(None)
    plant.apply_wrench([0.0, 0.0, 50.0], [0.0, 0.0, 0.0], frame='base_link')
    for _ in range(60):
        plant.step(None)
    reported = [(event.stamp // 1_000_000, json.loads(event.values['force']))
            for event in plant.drain_events() if event.kind == 'wrench']
    assert reported == [(2, [0.0, 0.0, 50.0]), (52, [0.0, 0.0, 0.0])]


def test_a_wrench_in_base_link_is_turned_by_half_a_turn(plant_of):
    a, b = plant_of(), plant_of()
    a.apply_wrench([10.0, 5.0, 3.0], [1.0, 2.0, 3.0])
    b.apply_wrench([-10.0, -5.0, 3.0], [-1.0, -2.0, 3.0], frame='base_link')
    for _ in range(20):
        np.testing.assert_array_equal(a.step(ZERO).q, b.step(ZERO).q)


@pytest.mark.parametrize(('force', 'frame'), [
    ([np.nan, 0.0, 0.0], 'base'), ([0.0, 0.0, 1.0], 'world'), ([0.0, 1.0], 'base'),
])
def test_a_senseless_wrench_is_refused(plant_of, force, frame):
    plant = plant_of()
    with pytest.raises(InputError):
        plant.apply_wrench(force, [0.0] * 3, frame)
    assert not plant.drain_events()


def test_payload_adds_to_what_the_record_declares():
    arm = loaded_arm(load_arm('ur5'), 2.0, [0.0, 0.0, 0.1])
    twice = loaded_arm(arm, 1.0, [0.0, 0.0, 0.1])
    assert twice.bodies[0][5] == pytest.approx(load_arm('ur5').mass[5] + 3.0)


@pytest.mark.parametrize('display', ['', ':987', 'nonsense', 'localhost:59000'])
def test_a_window_without_a_screen_is_refused_before_pybullet_ends_the_process(
        plant_of, monkeypatch, display):
    monkeypatch.setenv('DISPLAY', display)
    with pytest.raises(InputError, match='set gui to false'):
        plant_of(gui=True)


@pytest.mark.parametrize('given', [
    {}, {'physics_rate': 4000}, {'arm': 'ur10e'}, {'overspeed_stop': True}, {'arm': 'ur5_real'}])
@pytest.mark.parametrize('seed', range(3))
def test_what_was_switched_on_and_off_again_leaves_no_trace(plant_of, given, seed):
    used, fresh = plant_of(**given), plant_of(**given)
    for name, on, off in (
            ('noise.position', 1e-4, 0.0), ('delay.command_periods', 2, 0),
            ('delay.state_periods', 2, 0), ('friction.viscous', [1.0] * 6, [0.0] * 6),
            ('payload.mass', 1.0, 0.0), ('gravity', [0.0, 0.0, 9.0], [])):
        used.change(name, on)
        for _ in range(5):
            used.step(ZERO)
        used.change(name, off)
    used.apply_wrench([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    used.step(ZERO)
    used.apply_wrench([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    for plant in (used, fresh):
        plant.step(None)
        plant.reset()
        plant.drain_events()
    before = used.counters, fresh.counters
    rng = np.random.default_rng(seed)
    for _ in range(1500):
        inertia = used.mechanics.bullet.mass_matrix(used.truth.q.tolist())
        push = rng.normal(size=6) * (1.0, 10.0, 60.0)[seed] - 5.0 * used.truth.qd
        command = used.mechanics.declared_gravity() + inertia @ push  # carried, shaken, damped
        if rng.random() < 0.01:
            command = None  # the fallback
        for one, other in zip(used.step(command)[1:], fresh.step(command)[1:], strict=True):
            np.testing.assert_array_equal(one, other)
        assert ([event[1:] for event in used.drain_events()]
                == [event[1:] for event in fresh.drain_events()])
        assert used.stopped == fresh.stopped
        if fresh.stopped or rng.random() < 0.002:
            used.reset()
            fresh.reset()
    counts = [{name: after[name] - count for name, count in earlier.items()}
              for after, earlier in zip((used.counters, fresh.counters), before, strict=True)]
    assert counts[0] == counts[1]
