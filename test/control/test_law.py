import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.computed_torque import TorqueLaw
from ur5_ros.control.controller import Controller, controller_from_parameters
from ur5_ros.control.gains import gains_from
from ur5_ros.control.torque_limits import effort_scale, limit_torque
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix
from ur5_ros.model.kinematics import jacobian
from ur5_ros.signals import JOINT_NAMES, ArmState, Reference, Torque

ARM = load_arm('ur5_real')
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
ZERO = np.zeros(6)
LIMIT = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])
six = st.lists(st.floats(-300.0, 300.0), min_size=6, max_size=6).map(np.array)
STIFF = {'kp': [400.0, 400.0, 300.0, 60.0, 60.0, 60.0], 'kd': [40.0, 40.0, 30.0, 5.0, 5.0, 5.0]}


def torque_of(mode, state, reference, arm, gains):
    parts, code = TorqueLaw(mode, arm, gains)(state, state.q, reference)
    assert code == 0
    return Torque(*parts)


@given(six)
def test_the_effort_limit_keeps_the_direction_of_the_torque(total):
    limited, acted = limit_torque(total, ZERO, LIMIT, ZERO, np.inf)
    assert np.all(np.abs(limited) <= LIMIT * (1 + 1e-12))
    assert_allclose(np.outer(limited, total), np.outer(total, limited), atol=1e-6)
    assert (acted == 'effort') == bool(np.any(np.abs(total) > LIMIT))
    if not acted:
        assert limited is total


@given(six, six, st.floats(0.01, 100.0))
def test_the_rate_limit_keeps_the_direction_of_the_change(total, last, change):
    total, last = total / 12.0, last / 12.0
    limited, acted = limit_torque(total, ZERO, LIMIT, last, change)
    step = limited - last
    assert np.all(np.abs(step) <= change * (1 + 1e-9))
    assert_allclose(np.outer(step, total - last), np.outer(total - last, step), atol=1e-6)
    assert (acted == 'rate') == bool(np.abs(total - last).max() > change)


@given(six, st.lists(st.floats(-100.0, 100.0), min_size=6, max_size=6).map(np.array))
def test_with_gravity_added_by_the_robot_the_limit_holds_for_the_sum(total, added):
    factor = effort_scale(total, added, LIMIT)
    within = np.abs(added) <= LIMIT
    assert np.all(np.abs(factor * total + added)[within] <= LIMIT[within] * (1 + 1e-9))
    if factor < 1.0 and within.all():  # as large as it can be
        assert np.any(np.abs(factor * total + added) >= LIMIT * (1 - 1e-9))


def test_in_the_convention_without_gravity_m_a_and_c_qd_are_sent():
    arm = load_arm('ur5')
    state = ArmState(2_000_000, HOME, ZERO + 0.3, ZERO)
    whole, rest = (Controller(arm, {'effort_convention': name}, 500).update(state).torque
                   for name in ('total', 'gravity_excluded'))
    assert_allclose(whole.total - rest.total, gravity_torque(HOME, arm), atol=1e-12)
    assert_allclose(rest.total, rest.inertial + rest.feedback + rest.coriolis, atol=1e-12)
    assert not rest.gravity.any()
    assert_allclose(whole.coriolis, rest.coriolis)


def test_each_mode_is_the_sum_that_it_claims():
    gains = gains_from(**STIFF)
    state = ArmState(1, HOME, ZERO + 0.2, ZERO)
    reference = Reference(HOME + 0.1, ZERO, ZERO + 1.0)
    pd = torque_of('pd', state, reference, ARM, gains)
    assert_allclose(pd.total, 0.1 * np.array(STIFF['kp']) - 0.2 * np.array(STIFF['kd']))
    gravity_pd = torque_of('gravity_pd', state, reference, ARM, gains)
    assert_allclose(gravity_pd.total, pd.total + gravity_torque(HOME, ARM))
    impedance = torque_of('impedance', state, reference, ARM, gains)
    free = torque_of('computed_torque', state, Reference(HOME, ZERO + 0.2, ZERO + 1.0), ARM, gains)
    assert_allclose(impedance.total, pd.total + free.total, atol=1e-9)


@pytest.mark.parametrize('mode', ['computed_torque', 'gravity_pd', 'impedance'])
def test_modes_that_know_gravity_arrive_without_error(mode, holding, close_loop):
    gains = {} if mode == 'computed_torque' else STIFF
    controller, plant = holding(HOME, arm='ur5_real', mode=mode, **gains)
    controller.target_joints(JOINT_NAMES, HOME + 0.4)
    run = close_loop(controller, plant, 6000)
    assert run.status[-1] == 'holding'
    assert_allclose(run.q[-1], HOME + 0.4, atol=1e-4)
    assert not any(run.limited)


def test_plain_pd_sags_by_gravity_over_stiffness(holding, close_loop):
    controller, plant = holding(HOME, arm='ur5_real', mode='pd', **STIFF)
    run = close_loop(controller, plant, 4000)
    sag = -gravity_torque(run.q[-1], ARM) / np.array(STIFF['kp'])
    assert_allclose(run.error[-1], sag, atol=1e-5)


def test_impedance_yields_to_a_force_like_the_desired_spring(holding, close_loop):
    controller, plant = holding(HOME, arm='ur5_real', mode='impedance', **STIFF)
    force = np.array([5.0, -3.0, -10.0, 0.0, 0.0, 0.0])
    for _ in range(6000):
        answer = controller.update(plant.state)
        push = jacobian(plant.q, ARM).T @ force
        plant.step(answer.torque.total + push)
    yielded = np.linalg.solve(np.diag(STIFF['kp']), jacobian(plant.q, ARM).T @ force)
    assert_allclose(plant.q - HOME, yielded, atol=1e-5)


def test_gains_change_while_it_runs_and_bad_ones_leave_the_old(holding, close_loop):
    controller, plant = holding(HOME)
    close_loop(controller, plant, 10)
    controller.change({'kp': [25.0], 'kd': [9.0]})
    plant.q = HOME + 0.01
    state = plant.state
    torque = controller.update(state).torque
    assert_allclose(torque.feedback, inertia_matrix(state.q, plant.arm) @ (ZERO - 0.25), atol=1e-9)
    for changes, words in (
            ({'kp': [-1.0]}, 'kp has the eigenvalue -1'),
            ({'kp': [1.0] * 7}, 'kp has 7 numbers; give 1 or 6 or 36'),
            ({'kd': [2000.0]}, 'unstable when sampled at 500 Hz'),
            ({'arm': 'ur5e'}, 'arm is read at the start only'),
            ({'kq': 1.0}, "unknown parameter 'kq'"),
            ({'mode': 'magic'}, 'give one of: computed_torque'),
            ({'kp': [30.0], 'kd': [float('nan')]}, 'kd is nan; give a finite number')):
        with pytest.raises(InputError, match=words):
            controller.change(changes)
    assert controller.parameters.kp == [25.0]
    plant.step(torque.total)
    plant.q, plant.qd = HOME + 0.01, ZERO
    assert_allclose(controller.update(plant.state).torque.feedback, torque.feedback, atol=1e-9)


def test_damping_that_a_held_torque_turns_into_shaking_is_refused_with_what_it_stands():
    # wrist 3 of the paper's arm has no rotor: 1e-4 kg m^2 stand 2 M / h = 0.2 N m s/rad
    words = r'kd of wrist_3_joint is 10 N m s/rad; for arm ur5 give at most about \[.*, 0\.1\]'
    with pytest.raises(InputError, match=words):
        controller_from_parameters({'mode': 'gravity_pd'}, 1000)


def test_stiffness_that_a_held_torque_turns_into_shaking_is_refused():
    with pytest.raises(InputError, match=r'unstable \(spectral radius .*\); lower kp'):
        Controller(load_arm('ur5_real'),
                   {'mode': 'impedance', 'kp': [1e7], 'kd': [100.0]}, 1000)


@pytest.mark.fault(4)
def test_a_torque_rate_limit_is_kept_and_flagged(holding, close_loop):
    controller, plant = holding(HOME, 1000, torque_rate_limit=200.0, experiment='joint_step')
    controller.start_experiment()
    run = close_loop(controller, plant, 6000)
    assert np.abs(np.diff(run.torque, axis=0)).max() <= 0.2 + 1e-9
    assert 'rate' in run.limited
    assert controller.status()['limited_periods'] == sum(map(bool, run.limited))
    assert_allclose(run.q[-1], HOME + 0.2, atol=2e-2)


def test_effort_limits_are_kept_and_flagged(close_loop, exact_arm):
    controller = controller_from_parameters({'kp': [4000.0], 'kd': [150.0]}, 1000)
    plant = exact_arm(controller.arm, 1000, HOME)
    close_loop(controller, plant, 1)
    plant.q = HOME + 0.2
    run = close_loop(controller, plant, 3)
    assert run.limited[0] == 'effort'
    assert np.all(np.abs(run.torque) <= LIMIT * (1 + 1e-12))
