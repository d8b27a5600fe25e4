"""Contact on a real robot: the observer's estimate against a known push, and no false alarm."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.contact_likely import TIMES, contact_likely
from ur5_ros.analysis.data.run import NodeRecord, Run, States
from ur5_ros.analysis.external_torque import (
    OBSERVER_GAIN,
    robot_external_torque,
    unexplained_torque,
)
from ur5_ros.analysis.identification.arm_file import write_arm
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.analysis.momentum_observer import first_order
from ur5_ros.config import load_arm
from ur5_ros.control.controller import Controller
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.kinematics import jacobian
from ur5_ros.model.parameters import with_payload
from ur5_ros.sim.plant import Plant

ARM = load_arm('ur5e_real')
TORQUE_CONSTANT = np.array([11.9, 11.8, 9.7, 10.3, 11.2, 14.6])
RATE, THIN = 500, 4
#: Time [s] and force [N] of a hand at the tool, in base.
PUSHES = ((2.0, 2.6, (0.0, 0.0, -60.0)), (4.0, 4.6, (45.0, 60.0, 0.0)))


def robot_log(experiment='multi_sine', pushes=(), seconds=6.0, seed=1, payload=0.0):
    """Return a look-alike of a robot's log: target torque, motor currents, noise; and J^T w."""
    plant = Plant(ARM, {'control_rate': RATE, 'physics_rate': RATE, 'friction.from_arm': True,
                        'payload.mass': payload})
    controller = Controller(ARM, {'experiment': experiment, 'autostart': True, 'kp': 100.0,
                                  'kd': 20.0, 'friction_feedforward': True}, RATE)
    state, rows, before = plant.state, [], np.zeros(6)
    for k in range(int(seconds * RATE)):
        force = next((each for begin, end, each in pushes if begin <= k / RATE < end), (0.0,) * 3)
        plant.apply_wrench(force, (0.0,) * 3)
        rows.append((state.q, state.qd, state.effort, before))
        before = jacobian(state.q, ARM)[:3].T @ force
        state = plant.step(controller.update(state).torque.total)
    plant.close()
    q, qd, effort, external = (np.array(part)[::THIN] for part in zip(*rows, strict=True))
    rng = np.random.default_rng(seed)
    qdd = np.gradient(qd, THIN / RATE, axis=0)
    stamp = (np.arange(1, len(q) + 1) * THIN * 1e9 / RATE).astype(np.int64)
    run = Run('log', stamp, States(q, qd + rng.normal(0.0, 1e-3, qd.shape),
                                   inverse_dynamics(q, qd, qdd, ARM)), RATE / THIN,
              current=effort / TORQUE_CONSTANT + rng.normal(0.0, 0.02, q.shape))
    return run, external


def of_arm(run, arm):
    return replace(run, control=NodeRecord(arm.name, arm, {'mode': 'unknown'}))


@pytest.fixture(scope='module')
def known():
    """The arm with its torque constants, and its open torque from a recording of its own."""
    arm = replace(ARM, torque_constant=TORQUE_CONSTANT)
    run, _ = robot_log('exciting', seconds=8.0, seed=7)
    return replace(arm, unexplained_torque=unexplained_torque(run, arm))


@pytest.mark.parametrize('seed', range(3))
def test_a_hand_is_found_when_it_pushes_and_as_strong_as_it_is(known, seed):
    run, external = robot_log(pushes=PUSHES, seed=seed)
    check, = contact_likely(of_arm(run, known))[0]
    assert check.verdict == 'fail'
    touches = check.details['touches']
    assert len(touches) == len(PUSHES), check.sentence
    for touch, (begin, end, _) in zip(touches, PUSHES, strict=True):
        assert begin <= touch['start'] < begin + 0.25 and touch['duration'] < end - begin + 0.4
    truth = first_order(external[1:], OBSERVER_GAIN, run.h)
    found = robot_external_torque(run, known)
    away = np.abs(found.estimate - truth) - found.held
    marks = TIMES * known.unexplained_torque
    assert (away.max(axis=0) < marks + 0.05 * np.abs(truth).max()).all()
    assert (np.abs(truth).max(axis=0) > 2.0 * marks).any()


@pytest.mark.parametrize(('experiment', 'seed'), [
    ('multi_sine', 0), ('multi_sine', 1), ('cartesian_circle', 2), ('joint_step', 3)])
def test_motion_without_contact_raises_no_alarm(known, experiment, seed):
    check, = contact_likely(of_arm(robot_log(experiment, seed=seed)[0], known))[0]
    assert check.verdict == 'pass' and 'no external torque lasts' in check.sentence, check.sentence


def test_a_load_that_is_not_declared_is_an_external_torque_and_a_declared_one_is_none(known):
    run, _ = robot_log(payload=3.0)
    check, = contact_likely(of_arm(run, known))[0]
    assert check.verdict == 'fail' and 'payload' in check.sentence
    declared = with_payload(known, 3.0)
    assert contact_likely(of_arm(run, declared))[0][0].verdict == 'pass'


def test_what_it_takes_comes_from_a_free_recording_and_is_kept_in_the_arm_file(tmp_path):
    free, other = robot_log('exciting', seconds=12.0)[0], robot_log('multi_sine', seed=3)[0]
    found = identify([free], load_arm('ur5e_real'), other, name='mine')
    assert np.allclose(found.arm.torque_constant, TORQUE_CONSTANT, rtol=0.1)
    write_arm(found, tmp_path / 'mine.yaml')
    arm = load_arm(str(tmp_path / 'mine.yaml'))
    for name in ('torque_constant', 'unexplained_torque'):
        assert np.array_equal(getattr(arm, name), getattr(found.arm, name))
    assert np.allclose(arm.unexplained_torque, unexplained_torque(other, arm))
    verdicts = [contact_likely(of_arm(robot_log(pushes=pushes, seed=5)[0], arm))[0][0].verdict
                for pushes in (PUSHES, ())]
    assert verdicts == ['fail', 'pass']


def test_an_arm_without_torque_constants_says_how_to_get_them():
    check, = contact_likely(of_arm(robot_log(seconds=0.5)[0], ARM))[0]
    assert check.verdict == 'not applicable' and 'ur5 identify RUN -o ARM.yaml' in check.sentence


@pytest.mark.parametrize('key', ['torque_constant', 'unexplained_torque'])
def test_numbers_of_the_motors_that_are_not_above_zero_are_refused(key):
    with pytest.raises(ValueError, match=f'{key}.*six numbers above zero'):
        replace(ARM, **{key: np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])})
