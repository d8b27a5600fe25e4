"""The loop without ROS is the two nodes without ROS: same law, same plant, same bits."""

import numpy as np
import pytest

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.bag.reader import open_bag
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import full_loop, run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.rollout import rollout
from ur5_ros.loop.run_config import run_config

ORDINARY = {
    'the paper': {},
    'another arm in the law': {'control_arm': 'ur5_kebria2016'},
    'another robot': {'arm': 'ur10e', 'initial_error': 0.0},
    'eight steps a period': {'control_rate': 125},
    'two steps a period': {'control_rate': 1000, 'physics_rate': 2000},
    'a payload that the law does not know': {
        'sim': {'payload.mass': 0.5, 'payload.com': [0.0, 0.0, 0.1]}},
    'gravity of another place': {'sim': {'gravity': [0.0, 0.0, -9.82]}},
    'other gains': {'control': {'kp': [20.0, 30.0, 40.0, 50.0, 60.0, 70.0], 'kd': [25.0]}},
    'joint space': {'experiment': 'multi_sine'},
    'viscous friction': {'sim': {'friction.viscous': [1.0] * 6}},
    'dry friction': {'sim': {'friction.viscous': [1.0] * 6, 'friction.coulomb': [0.1] * 6}},
    'noise': {'sim': {'noise.position': 1e-4, 'noise.velocity': 1e-3, 'seed': 3}},
    'late states': {'sim': {'delay.state_periods': 3}},
    'late commands': {'sim': {'delay.command_periods': 3, 'fallback': 'gravity_compensation'}},
    'commands later than the run': {'sim': {'delay.command_periods': 1000}},
    'rotor inertia': {'arm': 'ur5_real', 'control_arm': 'ur5_real'},
    'everything at once': {
        'arm': 'ur5_real', 'control_arm': 'ur5_real', 'control_rate': 500,
        'sim': {'delay.state_periods': 1, 'delay.command_periods': 2, 'noise.position': 1e-5,
                'noise.velocity': 1e-4, 'seed': 5, 'friction.viscous': [0.5] * 6,
                'friction.coulomb': [0.2] * 6, 'payload.mass': 0.4}},
}
IMPERFECT = ('noise', 'late states', 'late commands', 'commands later than the run',
             'everything at once')
OTHER = {
    'another law': {'control': {'mode': 'gravity_pd', 'kp': [50.0], 'kd': [0.05]}},
    'gravity left to the robot': {'sim': {'effort_convention': 'gravity_excluded'}},
    'a torque limit touched': {'initial_error': [0.0, -0.4, 0.0, 0.0, 0.0, 0.0],
                               'control': {'kp': [900.0], 'kd': [60.0]}},
    'a start too far away': {'initial_error': 0.6},
}


def arrays(run):
    return (run.stamp, run.q, run.qd, run.effort, run.torque, *run.reference)


@pytest.mark.parametrize('case', ORDINARY)
def test_the_short_way_gives_the_bits_of_the_long_way(case):
    plan = run_config(duration=0.6, **ORDINARY[case])
    short, long = rollout(plan), full_loop(plan)
    assert short is not None
    for a, b in zip(arrays(short), arrays(long), strict=True):
        assert a.shape == b.shape and a.tobytes() == b.tobytes()
    assert short.events == long.events and bool(short.events) == ('commands' in case or (
        case == 'everything at once'))
    for run in (short, long):
        assert (run.truth is None) == (case not in IMPERFECT[:2] + IMPERFECT[-1:])
    if short.truth is not None:
        for a, b in zip(short.truth, long.truth, strict=True):
            assert a.shape == b.shape and a.tobytes() == b.tobytes()


def test_a_run_does_not_depend_on_the_run_before():
    plans = [run_config(duration=0.2, **ORDINARY[case]) for case in (
        'the paper', 'rotor inertia', 'the paper', 'a payload that the law does not know',
        'two steps a period', 'the paper', 'everything at once', 'everything at once')]
    digests = [[array.tobytes() for array in arrays(rollout(plan))] for plan in plans]
    assert digests[0] == digests[2] == digests[5] and digests[6] == digests[7]
    assert digests[0] != digests[3]


@pytest.mark.parametrize('case', OTHER)
def test_what_is_not_ordinary_takes_the_long_way(case):
    plan = run_config(duration=0.3, **OTHER[case])
    assert rollout(plan) is None
    run = run_closed_loop(plan)
    assert len(run.stamp) == 300 and np.isfinite(run.q).all()


def test_the_loop_obeys_the_sampled_error_equation_and_newtons():
    run = as_run(run_closed_loop(run_config(duration=2.0)))
    result = validate(run)
    for name in ('residual, controller arm', 'residual, simulator arm', 'error step',
                 'error recursion'):
        assert result.check(name).value <= 1e-9, result.check(name)


def test_bags_and_memory_hold_the_same_run(tmp_path):
    plan = run_config(duration=0.4, sim={'noise.velocity': 1e-3, 'delay.command_periods': 1})
    loop = run_closed_loop(plan, tmp_path / 'run')
    memory, read = as_run(loop), load_run(tmp_path / 'run')
    assert memory.stamp.tolist() == read.stamp.tolist()
    for a, b in ((memory.states, read.states), (memory.truth, read.truth),
                 (memory.reference, read.reference), ([memory.command], [read.command])):
        for x, y in zip(a, b, strict=True):
            assert x.tobytes() == y.tobytes()
    assert memory.sim.parameters.items() == read.sim.parameters.items()
    assert not read.problems


def test_a_recorded_run_is_not_overwritten(tmp_path):
    plan = run_config(duration=0.05)
    run_closed_loop(plan, tmp_path / 'run')
    before = {path: path.read_bytes() for path in (tmp_path / 'run').rglob('*.*')}
    with pytest.raises(InputError, match='exists'):
        run_closed_loop(plan, tmp_path / 'run')
    assert {path: path.read_bytes() for path in (tmp_path / 'run').rglob('*.*')} == before


def test_both_bags_say_what_they_are(tmp_path):
    run_closed_loop(run_config(duration=0.05, control_arm='ur5_kebria2016'), tmp_path / 'run')
    sim, control = open_bag(tmp_path / 'run' / 'sim'), open_bag(tmp_path / 'run' / 'control')
    assert sim.description['run'] == control.description['run'] == 'run'
    assert (sim.description['arm_name'], control.description['arm_name']) == (
        'ur5', 'ur5_kebria2016')
    states, commands = (sim.notes['summary']['hashes'][name]
                        for name in ('joint_states', 'joint_command'))
    assert len(states) == len(commands) == 64 and states != commands
    assert sim.check() == control.check() == []


@pytest.mark.parametrize(('wish', 'named'), [
    ({'control_rate': 300, 'physics_rate': 1000}, 'use 250 or 500'),
    ({'arm': 'ur5_controller'}, 'point mass'),
    ({'arm': 'ur55'}, 'ur55'),
    ({'experiment': 'fig12'}, 'fig12'),
    ({'control': {'kp': [-1.0]}}, 'kp'),
    ({'control': {'speed': 1.0}}, 'speed'),
    ({'sim': {'payload.mass': -1.0}}, 'payload.mass'),
])
def test_what_cannot_run_is_refused_before_it_runs(wish, named):
    with pytest.raises(InputError, match=named):
        run_config(**wish)
