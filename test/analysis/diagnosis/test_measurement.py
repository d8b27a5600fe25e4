"""Efforts that a robot measures wrongly: an offset, a factor, a delay; found beside the rest."""

import itertools

import numpy as np
import pytest
from foreign_recordings import arm_messages, gravity, motion, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.model.parameters import with_payload
from ur5_ros.signals import JOINT_NAMES

OFFSET = np.array([2.0, 5.0, -3.0, 1.0, 0.5, -0.3])


@pytest.fixture
def judged(tmp_path):
    """Return a function that judges a motion as one of arm ur5e."""
    count = itertools.count()

    def judge(made, **options):
        folder = write_bag(tmp_path / f'bag_{next(count)}', {'/joint_states': arm_messages(made)})
        return validate(load_run(folder, arm='ur5e', **options))
    return judge


def with_noise(made, size, seed):
    random = np.random.default_rng(seed)
    return made.with_(effort=made.effort + random.normal(0.0, size, made.q.shape))


def found(result):
    return {cause['kind']: cause for cause in result.causes}


@pytest.mark.parametrize('noise', [0.0, 0.3])
@pytest.mark.parametrize('offset', [OFFSET, -2.0 * OFFSET, 5.0 * np.eye(6)[1], 4.0 * np.eye(6)[3]])
def test_an_offset_of_the_efforts_is_named_with_its_size(judged, offset, noise):
    made = motion()
    result = judged(with_noise(made.with_(effort=made.effort + offset), noise, 1))
    assert result.verdict == 'fail' and set(found(result)) == {'torque offset'}
    joints = found(result)['torque offset']['joints']
    assert set(joints) == {name for name, size in zip(JOINT_NAMES, offset, strict=True) if size}
    for name, each in joints.items():
        assert each['value'] == pytest.approx(offset[JOINT_NAMES.index(name)], abs=0.1)
    assert 'set the torque sensors to zero' in found(result)['torque offset']['sentence']


def test_the_run_without_the_offset_that_was_named_passes(judged):
    made = motion()
    joints = found(judged(made.with_(effort=made.effort + OFFSET)))['torque offset']['joints']
    named = np.array([joints[name]['value'] for name in JOINT_NAMES])
    assert judged(made.with_(effort=made.effort + OFFSET - named)).verdict == 'pass'


@pytest.mark.parametrize('noise', [0.0, 0.3])
def test_an_offset_is_found_beside_friction(judged, noise):
    made = motion()
    friction = 4.0 * np.sign(made.qd) + 6.0 * made.qd
    causes = found(judged(with_noise(
        made.with_(effort=made.effort + friction + OFFSET), noise, 2)))
    assert set(causes) == {'Coulomb friction', 'viscous friction', 'torque offset'}
    for i, name in enumerate(JOINT_NAMES):
        assert causes['viscous friction']['joints'][name]['value'] == pytest.approx(6.0, abs=0.6)
        assert causes['torque offset']['joints'][name]['value'] == pytest.approx(
            OFFSET[i], abs=0.15)


@pytest.mark.parametrize('meaning', ['gravity_excluded', 'current'])
def test_with_the_meaning_stated_an_offset_is_found_beside_it(judged, meaning):
    made = motion()
    if meaning == 'current':
        result = judged(made.with_(effort=made.effort / 10.0 + 0.1 * OFFSET), effort=meaning)
        assert result.verdict == 'pass'
        return
    result = judged(made.with_(effort=made.effort - gravity(made) + OFFSET), effort=meaning)
    assert set(found(result)) == {'torque offset'}


@pytest.mark.parametrize('times', [0.9, 1.15])
def test_a_factor_of_every_joint_is_named_with_the_option(judged, times):
    made = motion()
    result = judged(made.with_(effort=times * made.effort))
    assert set(found(result)) == {'torque factor'}
    assert f'{times:g} at every joint' in result.causes[0]['sentence']
    assert judged(made.with_(effort=times * made.effort), effort='current').verdict == 'pass'


def test_a_factor_of_one_joint_is_named(judged):
    made = motion()
    result = judged(made.with_(effort=made.effort * np.array([1.0, 1.0, 1.3, 1.0, 1.0, 1.0])))
    assert found(result)['torque factor']['joints'] == {
        'elbow_joint': {'value': pytest.approx(1.3, abs=1e-3), 'error': pytest.approx(0, abs=0.1)}}


def test_efforts_behind_a_filter_are_named_late(judged):
    made, length = motion(), 40
    late = np.column_stack([np.convolve(np.pad(column, (length - 1, 0), 'edge'),
                                        np.ones(length) / length, 'valid')
                            for column in made.effort.T])
    causes = found(judged(made.with_(effort=late)))
    assert set(causes) == {'torque delay'}
    assert causes['torque delay']['delay_s'] == pytest.approx(0.5 * (length - 1) / 500.0, rel=0.05)


@pytest.mark.parametrize('seed', range(6))
def test_what_a_load_or_friction_does_is_no_wrong_measurement(judged, seed):
    random = np.random.default_rng(seed)
    arm = with_payload(load_arm('ur5e'), random.uniform(0.5, 5.0), random.uniform(-0.1, 0.1, 3))
    made = motion(arm)
    if seed % 2:
        made = made.with_(effort=made.effort + random.uniform(1.0, 5.0, 6) * np.sign(made.qd))
    kinds = set(found(judged(with_noise(made, 0.2, seed))))
    assert 'payload' in kinds and not any(each.startswith('torque') for each in kinds)
