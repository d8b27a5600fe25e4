"""The URDF: every engine reads the same arm out of it, and ROS finds its frames."""

import tempfile
import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio
import pybullet
import pytest

from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import dynamics_terms, forward_dynamics
from ur5_ros.model.kinematics import link_transforms
from ur5_ros.model.parameters import with_payload
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.urdf import LINK_NAMES, urdf_text

FRAMES = {'base_link', 'base', 'shoulder_link', 'upper_arm_link', 'forearm_link', 'wrist_1_link',
          'wrist_2_link', 'wrist_3_link', 'flange', 'tool0'}
BASE = np.diag([-1.0, -1.0, 1.0, 1.0])  # base_link <- base
RNG = np.random.default_rng(11)
POSES = RNG.uniform(-3.0, 3.0, (20, 6))


def turn(axis, angle):
    T = np.eye(4)
    T[:3, :3] = pinocchio.utils.rotate(axis, angle)
    return T


def move(x, y, z):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def test_the_tool_is_the_last_frame_of_the_model_in_base(every_arm, witness_of):
    witness = witness_of(every_arm)
    for q in POSES:
        found = witness.frames(q)
        T = link_transforms(q + every_arm.angle_offset, every_arm)
        np.testing.assert_allclose(found['tool0'], BASE @ T[5], atol=1e-14)
        np.testing.assert_allclose(found['base'], BASE, atol=1e-15)


def test_link_frames_stand_where_those_of_ur_description_do(every_arm, witness_of):
    # urdf/ur_macro.xacro of UniversalRobots/Universal_Robots_ROS2_Description, commit 2221ec0f,
    # with the lengths of config/<robot>/default_kinematics.yaml.
    witness = witness_of(every_arm)
    d, a = every_arm.d, -np.abs(every_arm.a)
    half = np.pi / 2
    for q in POSES[:5]:
        found = witness.frames(q)
        T = BASE.copy()
        for i, (link, step) in enumerate(zip(
                LINK_NAMES,
                (move(0, 0, d[0]), turn('x', half), move(a[1], 0, 0), move(a[2], 0, d[3]),
                 move(0, -d[4], 0) @ turn('x', half),
                 move(0, d[5], 0) @ turn('z', np.pi) @ turn('y', np.pi) @ turn('x', half)),
                strict=True)):
            T = T @ step @ turn('z', q[i])
            np.testing.assert_allclose(found[link], T, atol=1e-14, err_msg=link)
        flange = T @ turn('z', -half) @ turn('y', -half)
        np.testing.assert_allclose(found['flange'], flange, atol=1e-14)
        np.testing.assert_allclose(
            found['tool0'], flange @ turn('z', half) @ turn('x', half), atol=1e-14)


def test_every_frame_and_joint_has_its_name():
    robot = ET.fromstring(urdf_text(load_arm('ur5')))
    links = {link.get('name') for link in robot.iter('link')}
    assert links == FRAMES | {'base_link_inertia'}
    moving = [joint.get('name') for joint in robot.iter('joint') if joint.get('type') != 'fixed']
    assert tuple(moving) == JOINT_NAMES
    children = {joint.find('child').get('link') for joint in robot.iter('joint')}
    assert links - children == {'base_link'}, 'one root'


def test_a_prefix_stands_before_every_name():
    robot = ET.fromstring(urdf_text(load_arm('ur5'), tf_prefix='left_'))
    for element in (*robot.iter('link'), *robot.iter('joint')):
        if element.get('name'):
            assert element.get('name').startswith('left_')
    for tag in ('parent', 'child'):
        assert all(e.get('link').startswith('left_') for e in robot.iter(tag))


def test_a_prefix_that_would_break_the_document_is_refused():
    with pytest.raises(InputError, match='tf_prefix'):
        urdf_text(load_arm('ur5'), tf_prefix='a"><evil/>')


def test_a_body_without_a_tensor_is_refused_with_the_way_out():
    with pytest.raises(InputError, match='point mass.*ur5_real'):
        urdf_text(load_arm('ur5_controller'))


def test_nothing_but_visuals_so_that_no_engine_collides():
    robot = ET.fromstring(urdf_text(load_arm('ur5')))
    assert not list(robot.iter('collision'))
    assert len(list(robot.iter('visual'))) > 15
    assert not list(robot.iter('mesh'))


def test_three_engines_and_the_model_agree_on_the_dynamics(every_arm, witness_of):
    arm = with_payload(every_arm, 1.3, [0.02, -0.01, 0.06])
    text = urdf_text(arm)
    witness = witness_of(replace(arm, armature=np.zeros(6)))
    mj_model = mujoco.MjModel.from_xml_string(text)
    mj_model.opt.gravity[:] = arm.gravity  # a URDF holds none
    mj_data = mujoco.MjData(mj_model)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        with tempfile.NamedTemporaryFile('w', suffix='.urdf') as file:
            file.write(text)
            file.flush()
            body = pybullet.loadURDF(file.name, useFixedBase=True, physicsClientId=client,
                                     flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        pybullet.setGravity(*arm.gravity, physicsClientId=client)
        for q in POSES:
            qd = RNG.uniform(-2.0, 2.0, 6)
            M, C, g = dynamics_terms(q + arm.angle_offset, qd, arm)
            M -= np.diag(arm.armature)
            h = C @ qd + g
            size, force = np.abs(M).max(), np.abs(h).max()
            np.testing.assert_allclose(witness.mass_matrix(q), M, atol=1e-13 * size)
            np.testing.assert_allclose(witness.bias(q, qd), h, atol=1e-13 * force)
            np.testing.assert_allclose(
                pybullet.calculateMassMatrix(body, q.tolist(), physicsClientId=client), M,
                atol=1e-13 * size)
            np.testing.assert_allclose(
                pybullet.calculateInverseDynamics(body, q.tolist(), qd.tolist(), [0.0] * 6,
                                                  physicsClientId=client), h, atol=1e-12 * force)
            mj_data.qpos[:], mj_data.qvel[:] = q, qd
            mujoco.mj_forward(mj_model, mj_data)
            column = np.zeros(6)
            for i in range(6):
                mujoco.mj_mulM(mj_model, mj_data, column, np.eye(6)[i])
                np.testing.assert_allclose(column, M[:, i], atol=1e-12 * size)
            np.testing.assert_allclose(mj_data.qfrc_bias, h, atol=1e-12 * force)
    finally:
        pybullet.disconnect(client)


def test_limits_are_those_of_the_record_and_open_ones_make_a_continuous_joint():
    robot = ET.fromstring(urdf_text(load_arm('ur3e')))
    joints = {joint.get('name'): joint for joint in robot.iter('joint')}
    limits = load_arm('ur3e').limits
    for i, name in enumerate(JOINT_NAMES):
        limit = joints[name].find('limit')
        assert float(limit.get('effort')) == limits.effort[i]
        assert float(limit.get('velocity')) == limits.velocity[i]
        if np.isinf(limits.upper[i]):
            assert joints[name].get('type') == 'continuous'
        else:
            assert float(limit.get('upper')) == limits.upper[i]
    assert joints['wrist_3_joint'].get('type') == 'continuous'


@pytest.mark.parametrize('over', [0.0, 1e-15, 1e-9])
@pytest.mark.parametrize('seed', range(3))
def test_a_flat_body_keeps_its_tensor_in_the_simulator(seed, over):
    random = np.random.default_rng(seed)
    a, b = random.uniform(1e-3, 1e-2, 2)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    arm, rate = load_arm('ur5e'), 1000
    inertia = arm.inertia.copy()
    inertia[2] = turn @ np.diag([a, b, (a + b) * (1.0 + over)]) @ turn.T
    arm = replace(arm, inertia=0.5 * (inertia + inertia.transpose(0, 2, 1)))
    plant = Plant(arm, {'control_rate': rate, 'physics_rate': rate})
    state, torque = plant.state, np.array([20.0, -15.0, 10.0, 3.0, 2.0, 1.0])
    qdd = (plant.step(torque.tolist()).qd - state.qd) * rate
    plant.close()
    np.testing.assert_allclose(qdd, forward_dynamics(state.q, state.qd, torque, arm), atol=1e-5)
