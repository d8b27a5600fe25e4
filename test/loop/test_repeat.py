"""Recorded commands give the recorded states, and states the commands, to the last bit."""

import numpy as np
import pytest

from ur5_ros.analysis.comparison import compare
from ur5_ros.analysis.data.load import load_run
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.repeat import recontrol, resimulate
from ur5_ros.loop.run_config import run_config

KINDS = {
    'plain': {},
    'imperfect': {'arm': 'ur5_real', 'sim': {
        'friction.coulomb': [1.0, 1.0, 1.0, 0.2, 0.2, 0.2], 'noise.velocity': 1e-3,
        'delay.command_periods': 2, 'delay.state_periods': 1, 'payload.mass': 0.3}},
    'gravity excluded': {'sim': {'effort_convention': 'gravity_excluded'}},
    'eight steps a period': {'control_rate': 125},
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


def test_live_changes_wrenches_and_resets_are_repeated():
    from ur5_ros.analysis.data import run as series
    from ur5_ros.config import load_arm
    from ur5_ros.sim.plant import Plant
    plan = run_config(duration=0.2)
    plant = Plant(load_arm('ur5'), plan.sim)
    states, commands, events = [plant.state], [], []
    random = np.random.default_rng(1)
    for k in range(1, 200):
        if k == 40:
            plant.change('payload.mass', 1.5)
        if k == 60:
            plant.apply_wrench([5.0, 0.0, -3.0], [0.1, 0.0, 0.2])
        if k == 80:
            plant.change('friction.viscous', [2.0] * 6)
        commands.append(random.normal(size=6) * [20, 20, 20, 2, 2, 2])
        states.append(plant.reset() if k == 120 else plant.step(commands[-1]))
        events += plant.drain_events()
    plant.close()
    run = as_run(run_closed_loop(plan))
    recorded = series.Run(
        'changed', np.array([state.stamp for state in states]),
        series.States(*(np.array([state[i] for state in states]) for i in (1, 2, 3))), 1000.0,
        1000.0, command=np.array([*commands, np.zeros(6)]), sim=run.sim,
        events=as_run(run_closed_loop(plan)._replace(events=tuple(events))).events)
    assert {event.kind for event in events} >= {'parameter', 'wrench', 'reset'}
    found = resimulate(recorded)
    assert found.equal, found.sentence


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


def test_comparing_tells_where_two_runs_part_and_how_the_difference_grows():
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
