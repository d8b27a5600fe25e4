"""What all laws have in common: one interface, checked gains, live selection."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.parameters import CONTROL_PARAMETERS
from ur5_ros.control.controller import Controller
from ur5_ros.control.gains import gains_from
from ur5_ros.control.laws.registry import LAWS, make_law
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.signals import ArmState, Reference, Torque
from ur5_ros.sim.plant import Plant

REAL = load_arm('ur5_real')
START = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
GAINS = {'kp': [100.0], 'kd': [8.0], 'ki': [50.0]}
CHOICES = next(each for each in CONTROL_PARAMETERS if each.name == 'mode').choices


def state_and_reference(seed=1):
    q, qd, qr, qdr, qddr = np.random.default_rng(seed).uniform(-0.1, 0.1, (5, 6))
    return (ArmState(10_000_000, START + q, qd, np.zeros(6)),
            Reference(START + qr, qdr, qddr))


def law_of(mode, **control):
    parameters = ControlParameters.of({'mode': mode, **GAINS, **control})
    return make_law(parameters, REAL, gains_from(parameters.kp, parameters.kd))


def answer_of(law, state, reference):
    return law(state, state.q, reference, np.zeros(6), np.inf)


def test_every_choice_of_mode_is_a_law_and_every_law_a_choice():
    assert set(CHOICES) == set(LAWS)


@pytest.mark.parametrize('observer', [False, True])
@pytest.mark.parametrize('mode', CHOICES)
def test_the_total_is_the_sum_of_the_parts_and_the_robots_gravity_comes_off_it(mode, observer):
    state, reference = state_and_reference()
    parts, code = answer_of(law_of(mode, disturbance_observer=observer), state, reference)
    assert code == 0
    torque = Torque(*parts)
    assert_allclose(torque.total, parts[1:].sum(axis=0), atol=1e-9)
    without, _ = answer_of(law_of(mode, disturbance_observer=observer,
                                  effort_convention='gravity_excluded'), state, reference)
    assert_allclose(without[0], torque.total - torque.gravity, atol=1e-9)
    if mode not in ('pd', 'pid'):
        assert_allclose(torque.gravity, gravity_torque(state.q, REAL), atol=1e-9)


@pytest.mark.parametrize('mode', ['slotine_li', 'sliding_mode', 'adaptive',
                                  'computed_torque_integral'])
def test_on_the_reference_every_law_with_a_model_gives_the_torque_of_the_model(mode):
    state, reference = state_and_reference()
    reference = Reference(state.q, state.qd, reference.qdd)
    parts, _ = answer_of(law_of(mode), state, reference)
    model, _ = answer_of(law_of('computed_torque'), state, reference)
    assert_allclose(parts[0], model[0], atol=1e-8)


def test_near_the_reference_and_slowly_the_laws_of_slotine_and_li_are_a_damped_spring_of_m():
    state, reference = state_and_reference()
    still = ArmState(state.stamp, state.q, np.zeros(6), np.zeros(6))
    expected = Reference(reference.q, np.zeros(6), np.zeros(6))
    model, _ = answer_of(law_of('computed_torque'), still, expected)
    for mode in ('slotine_li', 'sliding_mode'):
        parts, _ = answer_of(law_of(mode, boundary_layer=[100.0]), still, expected)
        assert_allclose(parts[0], model[0], atol=1e-9)


@pytest.mark.parametrize('mode', CHOICES)
def test_a_state_that_is_not_finite_or_jumps_is_reported_before_the_law_sees_it(mode):
    state, reference = state_and_reference()
    law = law_of(mode)
    jump = state._replace(q=state.q + 1.0)
    assert law(jump, state.q, reference, np.zeros(6), np.inf)[1] & 1
    bad = state._replace(qd=np.full(6, np.nan))
    assert law(bad, state.q, reference, np.zeros(6), np.inf)[1] & 1
    assert answer_of(law, state, reference)[1] == 0


@pytest.mark.parametrize(('control', 'words'), [
    ({'mode': 'pid', 'ki': [1e6]}, r'pole with real part .* lower ki'),
    ({'mode': 'pid', 'kd': [1e4]}, 'kd of .* give at most about'),
    ({'mode': 'computed_torque_integral', 'ki': [801.0]}, r'Routh-Hurwitz\): lower ki'),
    ({'mode': 'computed_torque_integral', 'ki': [-1.0]}, 'ki has the eigenvalue -1'),
    ({'mode': 'slotine_li', 'kd': [2500.0]}, 'unstable when sampled at 1000 Hz'),
    ({'mode': 'sliding_mode', 'kd': [2500.0]}, 'unstable when sampled at 1000 Hz'),
    ({'mode': 'adaptive', 'adaptation_rate': 1e6}, r'adaptation_rate is 1e\+06; .* give less'),
    ({'mode': 'sliding_mode', 'boundary_layer': [0.0]}, 'boundary_layer is 0.0; give 1e-09'),
    ({'mode': 'fuzzy'}, "mode is 'fuzzy'; give one of: computed_torque"),
])
def test_gains_that_are_not_stable_are_refused_in_one_line(control, words):
    with pytest.raises(InputError, match=words) as refusal:
        Controller(REAL, {**GAINS, **control}, 1000)
    assert '\n' not in str(refusal.value)


def test_every_law_is_selected_live_and_holds_the_arm():
    controller = Controller(REAL, {'mode': 'computed_torque', **GAINS}, 1000)
    plant = Plant(REAL, {'initial_positions': START.tolist()})
    springs = {'kp': [400.0, 400.0, 300.0, 60.0, 60.0, 60.0],
               'kd': [40.0, 40.0, 30.0, 5.0, 5.0, 5.0]}
    try:
        for mode in CHOICES:
            weak = mode in ('pd', 'pid', 'gravity_pd', 'impedance')
            controller.change({'mode': mode, **(springs if weak else
                                                {'kp': GAINS['kp'], 'kd': GAINS['kd']})})
            for _ in range(300):
                answer = controller.update(plant.state)
                plant.step(answer.torque.total)
            assert controller.status()['mode'] == mode
            assert np.abs(plant.state.q - answer.reference.q).max() < 0.5
        controller.change({'mode': 'computed_torque', **GAINS, 'disturbance_observer': True})
        for _ in range(2500):
            plant.step(controller.update(plant.state).torque.total)
        assert np.abs(plant.state.q - answer.reference.q).max() < 1e-3
    finally:
        plant.close()


def test_a_change_of_motion_limits_keeps_what_the_law_has_learnt_and_one_of_gains_does_not():
    def next_feedback(change):
        controller = Controller(REAL, {'mode': 'pid', **GAINS, 'kp': [400.0], 'ki': [400.0],
                                       'kd': [5.0]}, 1000)
        zero, feedback = np.zeros(6), None
        for k in range(1, 400):
            if k == 399:
                controller.change(change)
            shift = 0.01 if k > 1 else 0.0
            feedback = controller.update(
                ArmState(k * 1_000_000, START + shift, zero, zero)).torque.feedback
        return feedback
    learnt = next_feedback({'max_velocity': [0.5]})
    assert_allclose(learnt, -400.0 * 0.01 - 400.0 * 0.01 * 0.398, atol=1e-9)
    assert_allclose(next_feedback({'ki': [401.0]}), -400.0 * 0.01, atol=1e-9)


def test_the_same_state_again_gives_the_same_answer_and_integrates_nothing():
    controller = Controller(REAL, {'mode': 'pid', **GAINS, 'kd': [5.0]}, 1000)
    zero = np.zeros(6)
    controller.update(ArmState(1_000_000, START, zero, zero))
    state = ArmState(2_000_000, START + 0.01, zero, zero)
    first = controller.update(state)
    assert controller.update(state) is first
    later = controller.update(ArmState(3_000_000, START + 0.01, zero, zero))
    assert_allclose(later.torque.feedback - first.torque.feedback, -50.0 * 0.01 * 1e-3, atol=1e-12)


def test_after_a_clock_that_goes_back_a_law_begins_anew():
    law, (state, reference) = law_of('pid'), state_and_reference()
    first, _ = answer_of(law, state, reference)
    answer_of(law, state._replace(stamp=state.stamp + 500_000_000), reference)
    again, _ = answer_of(law, state._replace(stamp=5), reference)
    assert_allclose(again, first, atol=1e-12)
