"""Laws of the kinematics, witnessed by Pinocchio and by plain products of DH transforms."""

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.kinematics import (
    forward_kinematics,
    jacobian,
    jacobian_rate,
    link_transforms,
    singularity_factors,
)


def states(count, seed):
    return np.random.default_rng(seed).uniform(-2.0 * np.pi, 2.0 * np.pi, (2, count, 6))


def dh_product(q, arm):
    """Return the six link frames by multiplying standard DH transforms, as the book does."""
    t, frames = np.eye(4), []
    for i in range(6):
        c, s = np.cos(q[i]), np.sin(q[i])
        ca, sa = np.cos(arm.alpha[i]), np.sin(arm.alpha[i])
        t = t @ np.array([[c, -s * ca, s * sa, arm.a[i] * c], [s, c * ca, -c * sa, arm.a[i] * s],
                          [0.0, sa, ca, arm.d[i]], [0.0, 0.0, 0.0, 1.0]])
        frames.append(t)
    return np.array(frames)


def test_pinocchio_finds_the_same_pose_jacobian_and_rate(arm, pinocchio_model):
    import pinocchio as pin
    model = pinocchio_model(arm)
    data = model.createData()
    tool = model.getFrameId('tool0')
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    q, qd = states(1000, 1)
    ours = forward_kinematics(q, arm), jacobian(q, arm), jacobian_rate(q, qd, arm)
    for i in range(len(q)):
        pin.computeJointJacobiansTimeVariation(model, data, q[i], qd[i])
        pin.updateFramePlacements(model, data)
        np.testing.assert_allclose(ours[0][i], data.oMf[tool].homogeneous, atol=1e-12)
        np.testing.assert_allclose(ours[1][i], pin.getFrameJacobian(model, data, tool, frame),
                                   atol=1e-12)
        np.testing.assert_allclose(
            ours[2][i] @ qd[i],
            pin.getFrameJacobianTimeVariation(model, data, tool, frame) @ qd[i], atol=1e-10)


def test_link_frames_are_the_products_of_the_dh_transforms(arm):
    for q in states(200, 2)[0]:
        frames = dh_product(q, arm)
        np.testing.assert_allclose(link_transforms(q, arm), frames, atol=1e-12)
        np.testing.assert_allclose(forward_kinematics(q, arm), frames[5], atol=1e-12)


def test_jacobian_is_the_derivative_of_the_pose(arm):
    q = states(50, 3)[0]
    h, steps = 1e-3, np.eye(6)
    ahead, behind, far, rear = (forward_kinematics(q[:, None] + k * h * steps, arm)
                                for k in (1.0, -1.0, 2.0, -2.0))
    slope = (8.0 * (ahead - behind) - (far - rear)) / (12.0 * h)  # (n, joint, 4, 4)
    j = jacobian(q, arm)
    np.testing.assert_allclose(np.swapaxes(slope[..., :3, 3], 1, 2), j[:, :3], atol=1e-10)
    spin = slope[..., :3, :3] @ np.swapaxes(forward_kinematics(q, arm)[:, None, :3, :3], -1, -2)
    w = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=1)
    np.testing.assert_allclose(w, j[:, 3:], atol=1e-10)


def test_jacobian_rate_is_the_derivative_of_the_jacobian_along_the_motion(arm):
    q, qd = states(50, 4)
    h = 1e-3

    def at(k):
        return jacobian(q + k * h * qd / 6.0, arm)

    slope = 6.0 * (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * h)
    np.testing.assert_allclose(jacobian_rate(q, qd, arm), slope, atol=1e-8)


def test_det_j_is_the_product_of_the_singularity_factors(arm):
    q = states(500, 5)[0]
    sin_q5, sin_q3, x5 = singularity_factors(q, arm)
    np.testing.assert_allclose(np.linalg.det(jacobian(q, arm)),
                               arm.a[1] * arm.a[2] * sin_q3 * sin_q5 * x5, atol=1e-14)


@pytest.mark.parametrize('name', ['ur5', 'ur10e'])
def test_both_signs_of_a2_a3_give_the_same_pose(name):
    from dataclasses import replace
    arm = load_arm(name)
    mirrored = replace(arm, a=-arm.a)
    q = states(200, 6)[0]
    shift = np.array([0.0, np.pi, 0.0, -np.pi, 0.0, 0.0])
    np.testing.assert_allclose(forward_kinematics(q + shift, mirrored),
                               forward_kinematics(q, arm), atol=1e-13)


def test_paper_angles_are_the_manufacturers_plus_the_offset():
    paper, ur5 = load_arm('ur5_kebria2016'), load_arm('ur5')
    q = states(200, 7)[0]
    apart = forward_kinematics(q + paper.angle_offset, paper) - forward_kinematics(q, ur5)
    assert np.abs(apart[:, :3, :3]).max() < 1e-13
    # the digit swap in d5: 90 micrometres (and 1 in d1)
    np.testing.assert_allclose(np.linalg.norm(apart[:, :3, 3], axis=1), 9e-5, atol=1.1e-6)
