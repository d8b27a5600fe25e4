"""Recorded commands give the recorded states, and states the commands, to the last bit."""

import numpy as np
import pytest

from ur5_ros.analysis.comparison import compare
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.plant_integrator import plant_models
from ur5_ros.analysis.residual import command_defect, residual
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.repeat import recontrol, resimulate
from ur5_ros.loop.run_config import run_config

#: What makes a period of silence.
SILENCE = object()

KINDS = {
    'plain': {},
    'imperfect': {'arm': 'ur5_real', 'sim': {
        'friction.coulomb': [1.0, 1.0, 1.0, 0.2, 0.2, 0.2], 'noise.velocity': 1e-3,
        'delay.command_periods': 2, 'delay.state_periods': 1, 'payload.mass': 0.3}},
    'gravity excluded': {'sim': {'effort_convention': 'gravity_excluded'}},
    'eight steps a period': {'control_rate': 125},
    "a robot's friction": {'sim': {
        'friction.viscous': [5.0] * 6, 'friction.static': [2.0] * 6,
        'friction_compensation.viscous_scale': [0.9] * 6, 'torque_rate_limit': 2e4,
        'effort_feedback': 'current', 'torque_constant': [12.0] * 6}},
    'at the torque limit': {'initial_error': [0.0, -0.4, 0.0, 0.0, 0.0, 0.0],
                            'control': {'kp': [900.0], 'kd': [60.0]}},
}


@pytest.mark.parametrize('kind', KINDS)
def test_a_recording_repeats_in_both_directions(kind, tmp_path):
    run_closed_loop(run_config(duration=0.4, **KINDS[kind]), tmp_path / 'run')
    run = load_run(tmp_path / 'run')
    for found in (resimulate(run), recontrol(run)):
        assert found.equal, found.sentence
        assert found.compared == len(run.stamp)
        assert found.same_machine


def resimulated(sim, happen):
    """Return the events and the repetition of a run in which ``happen(plant, k)`` acts."""
    from ur5_ros.analysis.data import run as series
    from ur5_ros.config import load_arm
    from ur5_ros.sim.plant import Plant
    plan = run_config(duration=0.2, sim=sim)
    plant = Plant(load_arm('ur5'), plan.sim)
    states, truths, commands, events = [plant.state], [plant.truth], [], []
    random = np.random.default_rng(1)
    for k in range(1, 200):
        commands.append(random.normal(size=6) * [20, 20, 20, 2, 2, 2])
        found = happen(plant, k)
        if found is SILENCE:
            commands[-1] = np.full(6, np.nan)
        states.append(found if isinstance(found, tuple) else plant.step(
            None if found is SILENCE else commands[-1]))
        truths.append(plant.truth)
        events += plant.drain_events()
    plant.close()
    looped = run_closed_loop(plan)
    columns = [series.States(*(np.array([state[i] for state in each]) for i in (1, 2, 3)))
               for each in (states, truths)]
    columns[0] = series.total_effort(columns[0], plan.sim.by_name(), load_arm('ur5'))
    recorded = series.Run(
        'changed', np.array([state.stamp for state in states]), columns[0], 1000.0,
        1000.0, columns[1], command=np.array([*commands, np.zeros(6)]), sim=as_run(looped).sim,
        events=as_run(looped._replace(events=tuple(events))).events)
    return recorded, resimulate(recorded)


def test_live_changes_wrenches_and_resets_are_repeated():
    def happen(plant, k):
        if k == 40:
            plant.change('payload.mass', 1.5)
        if k == 60:
            plant.apply_wrench([5.0, 0.0, -3.0], [0.1, 0.0, 0.2])
        if k == 80:
            plant.change('friction.viscous', [2.0] * 6)
        return plant.reset() if k == 120 else None

    recorded, found = resimulated({}, happen)
    assert {event.kind for event in recorded.events} >= {'parameter', 'wrench', 'reset'}
    assert found.equal, found.sentence


@pytest.mark.parametrize('feedback', ['total', 'gravity_excluded', 'current'])
def test_torque_mode_left_and_resumed_is_repeated_and_obeys_newton(feedback):
    def happen(plant, k):
        if k == 30:
            plant.change('payload.transition_time', 0.05)
            plant.change('payload.mass', 1.5)
        if k == 100:
            plant.change('friction_compensation.coulomb_scale', [0.5] * 6)
        if k == 150:
            plant.resume_torque_mode()
        return SILENCE if 120 <= k < 140 else None

    recorded, found = resimulated({
        'leave_torque_mode': True, 'torque_rate_limit': 1e4, 'friction.coulomb': [3.0] * 6,
        'friction.viscous': [4.0] * 6, 'friction_compensation.viscous_scale': [0.9] * 6,
        'effort_feedback': feedback, 'torque_constant': [12.0] * 6}, happen)
    assert {event.kind for event in recorded.events} >= {
        'parameter', 'payload', 'torque_mode', 'limit', 'fallback'}
    assert found.equal, found.sentence
    newton = residual(recorded, plant_models(recorded))
    assert np.nanmax(np.abs(newton.torque)) < 1e-9
    assert np.nanmax(np.abs(command_defect(recorded))) < 1e-9


def test_a_changed_bit_is_found_and_named(tmp_path):
    run_closed_loop(run_config(duration=0.2), tmp_path / 'run')
    run, other = load_run(tmp_path / 'run'), load_run(tmp_path / 'run')
    other.command[100, 3] = np.nextafter(other.command[100, 3], 1e9)
    found = recontrol(other)
    assert (found.different, found.first_joint) == (1, 'wrist_1_joint')
    assert found.first_stamp == run.stamp[100]
    assert '1 of 200 commands differ' in found.sentence
    found = resimulate(other)
    assert not found.equal and found.first_stamp == run.stamp[101]
    assert found.largest < 1e-9 and 'within 1e-09' in found.sentence


def test_comparing_shows_where_two_runs_differ_first_and_how_the_difference_grows():
    run = as_run(run_closed_loop(run_config(duration=0.3)))
    same = compare(run, as_run(run_closed_loop(run_config(duration=0.3))))
    assert same.identical and same.same and same.parameters == {}
    heavy = as_run(run_closed_loop(run_config(duration=0.3, sim={'payload.mass': 1e-6})))
    parted = compare(run, heavy)
    assert not parted.same
    assert parted.parameters == {'simulator payload.mass': [0.0, 1e-6]}
    position = parted.differences[0]
    assert position.quantity == 'position' and position.first_s == pytest.approx(0.001)
    assert position.growth['within 100 periods'] > position.growth['within 1 period']
    shorter = compare(run, as_run(run_closed_loop(run_config(duration=0.2))))
    assert (shorter.only_a, shorter.only_b, shorter.same) == (100, 0, False)


def test_runs_without_a_common_stamp_are_refused():
    run = as_run(run_closed_loop(run_config(duration=0.05)))
    late = as_run(run_closed_loop(run_config(duration=0.05))._replace(stamp=run.stamp + 10**9 + 7))
    with pytest.raises(InputError, match='no stamp in common'):
        compare(run, late)


def test_a_recording_with_a_gap_cannot_be_repeated(tmp_path):
    run_closed_loop(run_config(duration=0.1), tmp_path / 'run')
    run = load_run(tmp_path / 'run')
    holed = type(run)(**{**vars(run), 'stamp': np.delete(run.stamp, 50)})
    with pytest.raises(InputError, match='gap'):
        resimulate(holed)


@pytest.mark.fault(78)
def test_the_fingerprint_names_what_rounding_depends_on():
    assert {'python', 'numpy', 'numba', 'pybullet', 'processor'} <= fingerprint().keys()
