"""What each law promises, with PyBullet as the arm."""

import numpy as np
import pinocchio as pin
import pytest
from law_promises import (
    base_values,
    error_energy,
    layer_width,
    lyapunov,
    remaining_disturbance,
    steady_state_error,
)
from numpy.testing import assert_allclose
from witnesses import pinocchio_model

from ur5_ros.config import load_arm
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.controller import Controller
from ur5_ros.control.gains import gains_from
from ur5_ros.control.laws.computed_torque_integral import ComputedTorqueIntegral
from ur5_ros.control.laws.law import model_terms
from ur5_ros.control.laws.slotine_li import (
    SlotineLi,
    error_bandwidth,
    sliding_variable,
    square_root,
)
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.kinematics import jacobian
from ur5_ros.signals import Reference
from ur5_ros.sim.payload import loaded_arm
from ur5_ros.sim.plant import Plant

ARM, REAL = load_arm('ur5'), load_arm('ur5_real')
START = [0.3, -1.2, 1.5, -1.9, -1.4, 0.2]
SPRINGS = {'kp': [1500.0, 1500.0, 800.0, 200.0, 200.0, 100.0],
           'kd': [150.0, 150.0, 80.0, 15.0, 15.0, 8.0]}
STIFF = {'kp': [100.0], 'kd': [20.0]}
LOAD = 1.5


class Run:
    """A closed loop of PyBullet and the controller, a row a period."""

    def __init__(self, mode, duration, arm=ARM, plant_arm=None, sim=None, wrench=None,
                 experiment='', rate=1000, **control):
        given = {'mode': mode, 'experiment': experiment, 'autostart': bool(experiment), **control}
        self.controller = Controller(arm, given, rate)
        start = np.array(START)
        if experiment:
            start = self.controller.experiment.trajectory.at(0).q
        plant = Plant(plant_arm or arm, {'initial_positions': start.tolist(),
                                         'control_rate': rate, 'physics_rate': max(rate, 1000),
                                         **(sim or {})})
        self.law = getattr(self.controller.law, 'law', None)
        self.states, self.answers, self.memory = [], [], []
        try:
            for k in range(round(rate * duration)):
                answer = self.controller.update(plant.state)
                self.states.append(plant.state)
                self.answers.append(answer)
                self.memory.append(getattr(self.law, 'estimate', None))
                if wrench is not None and k == 50:
                    plant.apply_wrench(wrench[:3], wrench[3:])
                plant.step(answer.torque.total)
        finally:
            plant.close()
        self.q = np.array([state.q for state in self.states])
        self.qd = np.array([state.qd for state in self.states])
        self.torque = np.array([answer.torque.total for answer in self.answers])
        self.error = self.q - np.array([answer.reference.q for answer in self.answers])


def gains_of(control):
    return gains_from(control['kp'], control['kd'])


def test_pd_sags_by_gravity_at_the_reached_position_over_its_stiffness():
    run = Run('pd', 4.0, REAL, **SPRINGS)
    sag = steady_state_error(run.q[-1], REAL, gains_of(SPRINGS))
    assert np.abs(sag).max() > 0.01
    assert_allclose(run.error[-1], sag, rtol=0.01, atol=1e-5)
    model = pinocchio_model(REAL)
    gravity = pin.computeGeneralizedGravity(model, model.createData(),
                                            run.q[-1] + REAL.angle_offset)
    assert_allclose(run.error[-1], -gravity / SPRINGS['kp'], rtol=0.01, atol=1e-5)


@pytest.mark.parametrize('mode', ['gravity_pd', 'impedance'])
def test_a_spring_with_gravity_sags_by_the_payload_that_it_does_not_know(mode):
    run = Run(mode, 4.0, REAL, sim={'payload.mass': LOAD}, **SPRINGS)
    sag = steady_state_error(run.q[-1], loaded_arm(REAL, LOAD, [0.0] * 3), gains_of(SPRINGS), REAL)
    assert np.abs(sag).max() > 1e-3
    assert_allclose(run.error[-1], sag, rtol=0.01, atol=1e-5)


@pytest.mark.parametrize(('mode', 'arm', 'control'), [
    ('pid', REAL, {**SPRINGS, 'ki': [1500.0, 1500.0, 800.0, 200.0, 200.0, 100.0]}),
    ('computed_torque_integral', REAL, {**STIFF, 'ki': [300.0]}),
    ('computed_torque', ARM, {**STIFF, 'disturbance_observer': True}),
    ('gravity_pd', REAL, {**SPRINGS, 'disturbance_observer': True}),
])
def test_an_integral_and_an_observer_leave_no_error_at_rest_under_an_unknown_payload(
        mode, arm, control):
    run = Run(mode, 8.0, arm, sim={'payload.mass': LOAD}, **control)
    assert np.abs(run.error).max() > 1e-3  # there was something to learn
    assert np.abs(run.error[-1]).max() < 2e-5


def test_without_integral_the_same_payload_leaves_computed_torque_beside_its_target():
    run = Run('computed_torque', 6.0, sim={'payload.mass': LOAD}, **STIFF)
    assert np.abs(run.error[-1]).max() > 0.01


def test_with_an_exact_model_the_error_with_an_integral_obeys_a_linear_equation_of_third_order():
    kp, kd, ki = 100.0, 20.0, 200.0
    start = np.array([0.05, -0.04, 0.03, 0.05, -0.05, 0.04])
    law = ComputedTorqueIntegral(ARM, gains_from([kp], [kd]), ControlParameters.of(
        {'mode': 'computed_torque_integral', 'kp': [kp], 'kd': [kd], 'ki': [ki]}))
    goal, zero, errors = np.array(START), np.zeros(6), []
    plant = Plant(ARM, {'initial_positions': (goal + start).tolist()})
    try:
        for k in range(1500):
            errors.append(plant.state.q - goal)
            plant.step(law(plant.state, Reference(goal, zero, zero), 1e-3 if k else 0.0).total)
    finally:
        plant.close()
    # integral, error and rate of a joint: x' = A x from (0, e(0), 0)
    poles, modes = np.linalg.eig(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-ki, -kp, -kd]]))
    t = 1e-3 * np.arange(1500)
    shares = np.linalg.solve(modes, [0.0, 1.0, 0.0])
    promised = ((modes[1] * shares) * np.exp(np.outer(t, poles))).sum(axis=1).real
    assert promised.min() < -0.02  # the integral overshoots
    assert_allclose(np.array(errors) / start, np.tile(promised[:, None], 6), atol=0.02)


def test_the_energy_of_the_error_falls_under_slotine_and_li_as_exp_of_minus_2_k_t():
    rate = 8.0
    control = {'kp': [rate * 5.0], 'kd': [rate]}
    gains, goal = gains_of(control), np.array(START)
    law = SlotineLi(ARM, gains, ControlParameters.of({'mode': 'slotine_li', **control}))
    plant = Plant(ARM, {'initial_positions': (goal + 0.1).tolist()})
    zero, energy = np.zeros(6), []
    try:
        for _ in range(300):
            reference = Reference(goal, zero, zero)
            energy.append(error_energy(plant.state, reference, ARM, gains))
            plant.step(law(plant.state, reference, 1e-3).total)
    finally:
        plant.close()
    promised = energy[0] * np.exp(-2.0 * rate * 1e-3 * np.arange(300))
    assert_allclose(energy, promised, rtol=0.06)


def adaptive_run(mode, duration=10.0, rate=1000, **control):
    """A law that believes in 5 kg at the tool; there are 6."""
    law_arm, real = (loaded_arm(ARM, mass, [0.0, 0.0, 0.05]) for mass in (5.0, 6.0))
    return Run(mode, duration, law_arm, real, experiment='multi_sine', rate=rate, **STIFF,
               **control), real


def energy_and_loss(run, real, rate):
    """Return V at each state, and what -s'Ks has taken from it up to there in continuous time."""
    gains, law_arm, estimate = gains_of(STIFF), run.law.arm, run.law.estimate
    values, losses, true = [], [], base_values(run.law.arm, real)
    for state, answer, memory in zip(run.states, run.answers, run.memory, strict=True):
        run.law.estimate = memory
        values.append(lyapunov(run.law, true, state, answer.reference, real))
        s = sliding_variable(state, answer.reference, error_bandwidth(gains)).s
        root = square_root(gains.kd)
        losses.append(s @ root @ model_terms(state, law_arm)[0] @ root @ s / rate)
    run.law.estimate = estimate
    return np.array(values), np.concatenate([[0.0], np.cumsum(losses)[:-1]])


def test_adaptation_makes_v_fall_by_s_k_s_but_for_what_sampling_adds_which_a_faster_rate_halves():
    added = {}
    for rate in (500, 1000):
        run, real = adaptive_run('adaptive', 4.0, rate, adaptation_rate=300.0)
        values, loss = energy_and_loss(run, real, rate)
        added[rate] = values + loss - values[0]  # zero in continuous time
        assert values[-1] < 0.9 * values[0]
        assert values.max() < values[0] * 1.001 + np.abs(added[rate]).max()
    bound = {rate: np.abs(each).max() / values[0] for rate, each in added.items()}
    assert bound[1000] < 0.005
    assert bound[1000] < 0.6 * bound[500]


def test_adaptation_tracks_better_than_computed_torque_with_a_payload_20_percent_wrong():
    fixed, _ = adaptive_run('computed_torque')
    learned, _ = adaptive_run('adaptive', adaptation_rate=1000.0)
    last = slice(-2000, None)  # the last two of ten seconds
    rms = [np.sqrt((run.error[last]**2).mean()) for run in (fixed, learned)]
    assert rms[1] < 0.5 * rms[0]


def test_sliding_mode_stays_inside_the_layer_that_the_disturbance_predicts():
    control = {'kp': [100.0], 'kd': [20.0], 'boundary_layer': [2.0]}
    run = Run('sliding_mode', 4.0, sim={'payload.mass': 0.5}, experiment='multi_sine', **control)
    M, C, g = dynamics_terms(run.q, run.qd, ARM)
    modelled = np.linalg.solve(
        M, (run.torque - np.einsum('nij,nj->ni', C, run.qd) - g)[..., None])[..., 0]
    disturbance = np.abs(np.diff(run.qd, axis=0) * 1000.0 - modelled[:-1]).max(axis=0)
    gains = gains_of(control)
    s_bound, e_bound = layer_width(gains, np.full(6, 2.0), disturbance)
    assert np.isfinite(s_bound).all()
    rate = run.qd - np.array([answer.reference.qd for answer in run.answers])
    s = rate + run.error @ error_bandwidth(gains).T
    assert (np.abs(s) <= 1.02 * s_bound + 1e-4).all()
    assert (np.abs(run.error) <= 1.02 * e_bound + 1e-4).all()
    assert np.abs(s).max() > 0.1 * s_bound.max()  # the bound is not empty words


def test_the_layer_holds_nothing_beyond_the_push_of_the_law():
    gains = gains_from([100.0], [20.0])
    s, e = layer_width(gains, np.full(6, 0.5), np.array([1.0, 9.9, 10.0, 11.0, 0.0, 5.0]))
    assert_allclose(s, [0.05, 0.495, np.inf, np.inf, 0.0, 0.25])
    assert_allclose(e, s / 5.0)


def test_the_observer_learns_a_constant_push_with_its_time_constant():
    force = np.array([5.0, -3.0, -8.0, 0.0, 0.0, 0.0])
    gain = 15.0
    run = Run('computed_torque', 0.4, wrench=force, disturbance_observer=True,
              observer_gain=gain, **STIFF)
    steady = Run('computed_torque', 1.5, wrench=force, disturbance_observer=True,
                 observer_gain=gain, **STIFF)
    push = jacobian(steady.q[-1], ARM).T @ force
    assert_allclose(steady.law.disturbance, push, rtol=0.02, atol=0.02)
    left = remaining_disturbance(push, gain, 0.4 - 0.051)
    assert_allclose(push - run.law.disturbance, left, atol=0.03 * np.abs(push).max())


