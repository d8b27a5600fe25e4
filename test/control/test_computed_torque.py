import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.computed_torque import computed_torque
from ur5_ros.control.gains import gains_from
from ur5_ros.model.dynamics import forward_dynamics, inverse_dynamics
from ur5_ros.signals import ArmState, Reference

ARMS = {name: load_arm(name) for name in ('ur5', 'ur5_kebria2016', 'ur5_real', 'ur10e')}
six = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6).map(np.array)
GAINS = gains_from([10.0], [10.0])


def at(q, qd):
    return ArmState(1, q, qd, np.zeros(6))


@given(six, six, six, six, six, st.sampled_from(sorted(ARMS)))
def test_on_the_exact_model_the_error_obeys_its_equation(q, qd, q_ref, qd_ref, qdd_ref, name):
    arm = ARMS[name]
    torque = computed_torque(at(q, qd), Reference(q_ref, qd_ref, qdd_ref), arm, GAINS)
    qdd = forward_dynamics(q + arm.angle_offset, qd, torque.total, arm)
    e_dd, e_d, e = qdd - qdd_ref, qd - qd_ref, q - q_ref
    assert_allclose(e_dd + 10.0 * e_d + 10.0 * e, 0.0, atol=1e-8)


@given(six, six, six)
def test_on_the_reference_it_is_inverse_dynamics(q, qd, qdd):
    arm = ARMS['ur5']
    torque = computed_torque(at(q, qd), Reference(q, qd, qdd), arm, GAINS)
    assert_allclose(torque.total, inverse_dynamics(q, qd, qdd, arm), atol=1e-10)
    assert_allclose(torque.feedback, 0.0, atol=1e-12)


@given(six, six, six, six, six)
def test_the_parts_add_up(q, qd, q_ref, qd_ref, qdd_ref):
    torque = computed_torque(at(q, qd), Reference(q_ref, qd_ref, qdd_ref), ARMS['ur5'], GAINS)
    parts = torque.inertial + torque.feedback + torque.coriolis + torque.gravity
    assert_allclose(torque.total, parts, rtol=1e-15, atol=1e-12)


def test_full_matrices_couple_the_joints_as_written():
    random = np.random.default_rng(5)
    root = random.normal(size=(6, 6))
    kp = root @ root.T + np.eye(6)
    gains = gains_from(kp.ravel(), (2.0 * kp).ravel())
    arm = ARMS['ur5']
    q, e, e_d = random.normal(size=(3, 6))
    torque = computed_torque(at(q, e_d), Reference(q - e, np.zeros(6), np.zeros(6)), arm, gains)
    qdd = forward_dynamics(q, e_d, torque.total, arm)
    assert_allclose(qdd, -kp @ e - 2.0 * kp @ e_d, atol=1e-8)


def test_both_ways_to_write_the_ur5_give_the_same_torque():
    # Table I and the manufacturer differ by 90 micrometres and the angles' zero, not in physics
    random = np.random.default_rng(6)
    q, qd, q_ref, qd_ref, qdd_ref = random.uniform(-2.0, 2.0, size=(5, 6))
    one, two = (computed_torque(at(q, qd), Reference(q_ref, qd_ref, qdd_ref), ARMS[name], GAINS)
                for name in ('ur5', 'ur5_kebria2016'))
    assert_allclose(one.total, two.total, atol=0.02)
