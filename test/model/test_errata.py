"""
The misprints of the paper: the printed form is wrong, the corrected one right.

Everything is in the paper's convention (arm ur5_kebria2016, Table I); n, o, a are the columns of
the flange's rotation, which section II-D of the paper calls x, y, z.
"""

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import dynamics_terms, forward_dynamics, inertia_matrix
from ur5_ros.model.energy import potential_energy
from ur5_ros.model.inverse_kinematics import inverse_kinematics
from ur5_ros.model.kinematics import (
    forward_kinematics,
    jacobian,
    link_transforms,
    singularity_factors,
)

ARM = load_arm('ur5_kebria2016')
D1, D4, D5, D6 = ARM.d[[0, 3, 4, 5]]
A2, A3 = ARM.a[[1, 2]]
Q = np.random.default_rng(1).uniform(-np.pi, np.pi, (2000, 6))
POSE = forward_kinematics(Q, ARM)
N, O, A, P = (POSE[:, :3, i] for i in range(4))  # noqa: E741
S, C = np.sin(Q), np.cos(Q)
Q23, Q234 = Q[:, 1] + Q[:, 2], Q[:, 1] + Q[:, 2] + Q[:, 3]


def angle_error(a, b):
    return np.abs((a - b + np.pi) % (2.0 * np.pi) - np.pi)


def test_equation_2_needs_the_factor_s5_in_the_d6_terms():
    c1, s1, s5, c5 = C[:, 0], S[:, 0], S[:, 4], C[:, 4]

    def px_py(factor):
        reach = A2 * C[:, 1] + A3 * np.cos(Q23) + D5 * np.sin(Q234) - D6 * np.cos(Q234) * factor
        side = D4 + D6 * c5
        return np.stack([c1 * reach + s1 * side, s1 * reach - c1 * side], axis=1)

    np.testing.assert_allclose(px_py(s5), P[:, :2], atol=1e-14)
    off = np.linalg.norm(px_py(1.0) - P[:, :2], axis=1)
    assert 0.045 < off.mean() < 0.055
    assert 0.16 < off.max() <= 2 * D6 + 1e-12


def test_equation_2_is_right_in_pz():
    pz = (D1 - D6 * np.sin(Q234) * S[:, 4] + A3 * np.sin(Q23) + A2 * S[:, 1]
          - D5 * np.cos(Q234))
    np.testing.assert_allclose(pz, P[:, 2], atol=1e-14)


def test_the_line_for_theta_1_is_right():
    left = -S[:, 0] * (P[:, 0] - D6 * A[:, 0]) + C[:, 0] * (P[:, 1] - D6 * A[:, 1])
    np.testing.assert_allclose(left, -D4, atol=1e-14)


def test_the_angle_in_the_geometry_of_theta_1_has_cosine_d4_over_r_and_not_that_tangent():
    p5 = P - D6 * A
    phi, r = np.arctan2(p5[:, 1], p5[:, 0]), np.hypot(p5[:, 0], p5[:, 1])

    def error(angle):
        both = np.stack([phi + angle + np.pi / 2, phi - angle + np.pi / 2], axis=1)
        return angle_error(both, Q[:, :1]).min(axis=1)

    assert error(np.arccos(D4 / r)).max() < 1e-6  # as eq (3) itself has it
    assert np.median(error(np.arctan(D4 / r))) > 0.5


def test_the_wrist_may_come_as_near_to_axis_1_as_d4_and_no_nearer():
    p5 = P - D6 * A
    r = np.hypot(p5[:, 0], p5[:, 1])
    x5 = singularity_factors(Q, ARM)[2]
    np.testing.assert_allclose(r ** 2, x5 ** 2 + D4 ** 2, atol=1e-14)
    # R = |d4| is reached, which the paper excludes: above axis 1
    q = np.array([0.3, np.pi / 2, 0.0, -np.pi / 2, 1.0, 0.2])
    pose = forward_kinematics(q, ARM)
    on_axis = pose[:3, 3] - D6 * pose[:3, 2]
    assert abs(np.hypot(on_axis[0], on_axis[1]) - D4) < 1e-15
    assert len(inverse_kinematics(pose, ARM).q)


def test_the_line_for_theta_5_has_d6_and_not_d5():
    left = -S[:, 0] * P[:, 0] + C[:, 0] * P[:, 1]
    np.testing.assert_allclose(left, -D4 - C[:, 4] * D6, atol=1e-14)
    assert np.abs(left - (-D4 - C[:, 4] * D5)).max() > 0.01


def test_equation_4_is_right_and_its_argument_never_leaves_the_unit_interval():
    argument = (P[:, 0] * S[:, 0] - P[:, 1] * C[:, 0] - D4) / D6
    np.testing.assert_allclose(argument, A[:, 0] * S[:, 0] - A[:, 1] * C[:, 0], atol=1e-13)
    assert angle_error(np.arccos(np.clip(argument, -1.0, 1.0)), np.abs(Q[:, 4])).max() < 1e-6


def test_the_vector_for_theta_6_begins_with_minus_c6_s5_and_not_c5():
    # y of frame 1 (minus z of the paper's plane) seen from the flange
    seen = np.stack([-S[:, 0] * M[:, 0] + C[:, 0] * M[:, 1] for M in (N, O, A)], axis=1)
    right = np.stack([-C[:, 5] * S[:, 4], S[:, 5] * S[:, 4], -C[:, 4]], axis=1)
    np.testing.assert_allclose(seen, right, atol=1e-14)
    assert np.abs(seen[:, 0] + C[:, 5] * C[:, 4]).max() > 1.0


def test_equation_5_has_s1_and_c1_swapped_in_its_second_argument():
    s1, c1, s5 = S[:, 0], C[:, 0], S[:, 4]
    first = (-O[:, 0] * s1 + O[:, 1] * c1) / s5
    corrected = np.arctan2(first, (N[:, 0] * s1 - N[:, 1] * c1) / s5)
    printed = np.arctan2(first, (N[:, 0] * c1 - N[:, 1] * s1) / s5)
    assert angle_error(corrected, Q[:, 5]).max() < 1e-9
    assert np.count_nonzero(angle_error(printed, Q[:, 5]) < 1e-6) == 0


def test_where_s5_is_zero_only_a_sum_of_angles_is_fixed():
    q = Q[:200].copy()
    for q5, sign in ((0.0, 1.0), (np.pi, -1.0)):
        q[:, 4] = q5
        turned = q + 0.4 * np.array([0.0, 0.0, 0.0, -sign, 0.0, 1.0])
        one, other = forward_kinematics(q, ARM), forward_kinematics(turned, ARM)
        np.testing.assert_allclose(one[:, :3, :3], other[:, :3, :3], atol=1e-14)
        assert np.linalg.matrix_rank(jacobian(q[0], ARM), tol=1e-9) == 5


@pytest.mark.parametrize('q3', [0.0, np.pi])
def test_the_elbow_is_singular_outstretched_and_folded_although_a2_differs_from_a3(q3):
    q = Q[:50].copy()
    q[:, 2] = q3
    for one in q:
        assert np.linalg.matrix_rank(jacobian(one, ARM), tol=1e-9) == 5


def test_the_reach_of_joints_2_and_3_is_measured_in_the_plane_without_d4():
    frames = link_transforms(Q, ARM)
    wrist = frames[:, 2, :3, 3] - (0.0, 0.0, D1)  # frame 3: before the offset d4
    span = np.linalg.norm(wrist, axis=1)
    assert span.max() <= A2 + A3
    assert span.min() >= abs(A2 - A3)
    behind = np.linalg.norm(frames[:, 3, :3, 3] - (0.0, 0.0, D1), axis=1)
    np.testing.assert_allclose(behind ** 2, span ** 2 + D4 ** 2, atol=1e-14)


def test_one_pose_has_more_solutions_than_the_range_zero_to_two_pi_shows():
    turns = Q[0] + 2.0 * np.pi * np.array([1, -1, 0, 1, 0, -1])
    np.testing.assert_allclose(forward_kinematics(turns, ARM), POSE[0], atol=1e-13)


def test_equation_7_is_forward_dynamics():
    q, qd, tau = np.random.default_rng(2).uniform(-2.0, 2.0, (3, 6))
    m, c, g = dynamics_terms(q, qd, ARM)
    np.testing.assert_allclose(forward_dynamics(q, qd, tau, ARM),
                               np.linalg.solve(m, tau - c @ qd - g), rtol=1e-10)


def mass_matrix(points):
    """Return eq (8) with the linear Jacobian of given points of the links, at Q[:100]."""
    total = np.zeros((100, 6, 6))
    mass, _, inertia = ARM.bodies
    frames = link_transforms(Q[:100], ARM)
    axis = np.concatenate([np.tile([[[0.0, 0.0, 1.0]]], (100, 1, 1)), frames[:, :5, :3, 2]], 1)
    origin = np.concatenate([np.zeros((100, 1, 3)), frames[:, :5, :3, 3]], axis=1)
    for i in range(6):
        r = frames[:, i, :3, :3]
        x = r @ points[i] + frames[:, i, :3, 3]
        jv, jw = np.zeros((2, 100, 3, 6))
        for j in range(i + 1):
            jv[:, :, j] = np.cross(axis[:, j], x - origin[:, j])
            jw[:, :, j] = axis[:, j]
        total += mass[i] * np.swapaxes(jv, 1, 2) @ jv
        total += np.swapaxes(jw, 1, 2) @ r @ inertia[i] @ np.swapaxes(r, 1, 2) @ jw
    return total


def test_equation_8_holds_with_jacobians_of_the_centres_of_mass_only():
    ours = inertia_matrix(Q[:100], ARM)
    np.testing.assert_allclose(mass_matrix(ARM.bodies[1]), ours, atol=1e-13)
    assert np.abs(mass_matrix(np.zeros((6, 3))) - ours).max() > 0.1  # link origins instead


def test_the_manufacturers_centres_of_mass_must_be_turned_into_the_frames_of_table_1():
    ur5 = load_arm('ur5')
    turned = ARM.com * np.array([[1, 1, 1], [-1, -1, 1], [-1, -1, 1], [1, 1, 1], [1, 1, 1],
                                 [1, 1, 1]])
    np.testing.assert_allclose(turned, ur5.com, atol=1e-15)
    unturned = 9.81 * np.abs((ur5.com - ARM.com)[1:3, 0] @ ARM.mass[1:3])
    assert unturned > 35.0  # N m at joint 2, were they taken as printed


def test_equation_10_needs_heights_counted_upwards():
    frames = link_transforms(Q, ARM)
    mass, com, _ = ARM.bodies
    height = (frames[:, :, :3, :3] @ com[:, :, None])[..., 2, 0] + frames[:, :, 2, 3]
    np.testing.assert_allclose(potential_energy(Q, ARM), 9.81 * height @ mass, atol=1e-12)


def test_equations_11_and_12_leave_a_linear_error_equation():
    rng = np.random.default_rng(3)
    q, qd, e, ed, qdd_desired = rng.uniform(-1.0, 1.0, (5, 6))
    a = qdd_desired - 10.0 * ed - 10.0 * e
    m, c, g = dynamics_terms(q, qd, ARM)
    qdd = forward_dynamics(q, qd, m @ a + c @ qd + g, ARM)
    np.testing.assert_allclose((qdd - qdd_desired) + 10.0 * ed + 10.0 * e, 0.0, atol=1e-10)


def test_table_1_swaps_two_digits_of_d5():
    ur5 = load_arm('ur5')
    assert (ARM.d[4], ur5.d[4]) == (0.09456, 0.09465)
    shifted = forward_kinematics(Q - ARM.angle_offset, ur5)[:, :3, 3] - P
    np.testing.assert_allclose(np.linalg.norm(shifted, axis=1), 9e-5, atol=1.1e-6)
