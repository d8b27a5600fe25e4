"""A sweep is refused by the name of the key; its runs depend on nothing but seed and index."""

import pytest

from ur5_ros.errors import InputError
from ur5_ros.sweep.spec import expand, number_of_runs, parse_sweep

HEAD = 'name: trial\n'


def values(text):
    return [run.values for run in expand(parse_sweep(HEAD + text, 'trial.yaml'))]


def test_a_grid_has_every_combination_and_every_sample():
    spec = parse_sweep(
        HEAD + 'samples: 3\nvary:\n  sim.payload.mass: [0.0, 1.0]\n'
        '  control.kp: {from: 5.0, to: 20.0, count: 4}\n', 'trial.yaml')
    runs = list(expand(spec))
    assert len(runs) == number_of_runs(spec) == 24
    assert [run.number for run in runs] == list(range(24))
    pairs = {(run.values['sim.payload.mass'], run.values['control.kp']) for run in runs}
    assert pairs == {(mass, kp) for mass in (0.0, 1.0) for kp in (5.0, 10.0, 15.0, 20.0)}


def test_a_logarithmic_range_has_equal_ratios():
    found = [run['control.kp'] for run in values(
        'vary:\n  control.kp: {from: 1.0, to: 100.0, count: 3, scale: log}\n')]
    assert found == pytest.approx([1.0, 10.0, 100.0])


def test_random_values_of_a_run_do_not_depend_on_how_many_there_are():
    axis = 'vary:\n  initial_error: {uniform: [-0.1, 0.1], size: 6}\n'
    few = values('samples: 3\nseed: 5\n' + axis)
    many = values('samples: 9\nseed: 5\n' + axis)
    other = values('samples: 3\nseed: 6\n' + axis)
    assert many[:3] == few
    assert other != few
    flat = [x for run in many for x in run['initial_error']]
    assert len(set(flat)) == 54 and max(map(abs, flat)) <= 0.1


def test_cases_vary_together():
    found = values('cases:\n  - {arm: ur5, control_arm: ur5}\n  - {arm: ur5_real, control_arm: '
                   'ur5}\nvary:\n  control_rate: [500, 1000]\n')
    assert [(run['arm'], run['control_arm'], run['control_rate']) for run in found] == [
        ('ur5', 'ur5', 500), ('ur5', 'ur5', 1000),
        ('ur5_real', 'ur5', 500), ('ur5_real', 'ur5', 1000)]


@pytest.mark.parametrize(('text', 'named'), [
    ('vary:\n  control.kp: []\n', 'control.kp'),
    ('vary:\n  control.kp: {from: 5.0, to: 1.0, count: 3}\n', 'control.kp'),
    ('vary:\n  control.kp: {from: 5.0, to: 1.0}\n', 'control.kp'),
    ('vary:\n  control.kp: {uniform: [1.0, 1.0]}\n', 'control.kp'),
    ('vary:\n  control.kp: {log_uniform: [0.0, 1.0]}\n', 'control.kp'),
    ('vary:\n  control.kp: {normal: [0.0, -1.0]}\n', 'control.kp'),
    ('vary:\n  control.kp: {uniform: [0.0, 1.0], normal: [0.0, 1.0]}\n', 'control.kp'),
    ('vary:\n  control.kp: {steps: 5}\n', 'steps'),
    ('varry:\n  control.kp: [1.0]\n', 'varry'),
    ('samples: 0\n', 'samples'),
    ('fixed: {arm: ur5}\nvary:\n  arm: [ur5]\n', 'arm'),
    ('cases: [{arm: ur5}, {control_arm: ur5}]\n', 'cases.1'),
    ('cases: [{arm: ur5}]\nfixed: {arm: ur5}\n', 'cases.0'),
    ('samples: 1000000\nvary:\n  control.kp: [1.0, 2.0]\n', '2000000 runs'),
    ('duration: -1.0\n', 'duration'),
])
def test_what_makes_no_sense_is_refused_by_name(text, named):
    with pytest.raises(InputError, match='trial.yaml') as refusal:
        parse_sweep(HEAD + text, 'trial.yaml')
    assert named in str(refusal.value)
    assert '\n' not in str(refusal.value)
