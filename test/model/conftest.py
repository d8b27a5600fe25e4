"""Witnesses: the same arms in Pinocchio, PyBullet and MuJoCo, built from the explicit inertias."""

import numpy as np
import pytest

from ur5_ros.config import list_arms, load_arm

ARMS = list_arms()
SIMULATED = [name for name in ARMS if load_arm(name).has_tensors]


@pytest.fixture(params=ARMS)
def arm(request):
    return load_arm(request.param)


@pytest.fixture(params=SIMULATED)
def simulated_arm(request):
    return load_arm(request.param)


@pytest.fixture(scope='session')
def pinocchio_model():
    """Return a function: arm -> pinocchio.Model with frame 'tool0'."""
    pytest.importorskip('pinocchio')
    from witnesses import pinocchio_model
    return pinocchio_model


@pytest.fixture
def bullet_body(tmp_path):
    """Return a function: arm -> (client, body) in PyBullet, joint angles those of the record."""
    bullet = pytest.importorskip('pybullet')
    clients = []

    def build(arm):
        lines, parent, origin = ['<robot name="arm"><link name="l0"/>'], 'l0', (0.0, 0.0, 0.0)
        for i, (mass, com, inertia) in enumerate(zip(*arm.bodies, strict=True)):
            turn = arm.alpha[i]
            c, s = np.cos(turn), np.sin(turn)
            link = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            # principal axes: PyBullet's own diagonalisation is good to three digits only
            moments, own = np.linalg.eigh(inertia)
            order = np.argsort(np.abs(own).argmax(axis=0))  # near the link axes: no gimbal lock
            moments, own = moments[order], own[:, order]
            own *= np.sign(np.diag(own))
            assert np.isclose(np.linalg.det(own), 1.0)
            r = link @ own
            rpy = (np.arctan2(r[2, 1], r[2, 2]), np.arcsin(-r[2, 0]), np.arctan2(r[1, 0], r[0, 0]))
            lines.append(
                f'<link name="l{i + 1}"><inertial><mass value="{float(mass)!r}"/>'
                f'<origin xyz="{_text(link @ com + (arm.a[i], 0, arm.d[i]))}" '
                f'rpy="{_text(rpy)}"/><inertia ixx="{float(moments[0])!r}" ixy="0" ixz="0" '
                f'iyy="{float(moments[1])!r}" iyz="0" izz="{float(moments[2])!r}"/>'
                '</inertial></link>'
                f'<joint name="j{i + 1}" type="continuous"><parent link="{parent}"/>'
                f'<child link="l{i + 1}"/><axis xyz="0 0 1"/>'
                f'<origin xyz="{origin[0]!r} 0 {origin[2]!r}" rpy="{origin[1]!r} 0 0"/></joint>')
            parent, origin = f'l{i + 1}', (float(arm.a[i]), float(turn), float(arm.d[i]))
        path = tmp_path / f'{arm.name}.urdf'
        path.write_text('\n'.join([*lines, '</robot>']))
        client = bullet.connect(bullet.DIRECT)
        clients.append(client)
        bullet.setGravity(*arm.gravity, physicsClientId=client)
        body = bullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client,
                               flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        return client, body

    yield build
    for client in clients:
        bullet.disconnect(physicsClientId=client)


@pytest.fixture(scope='session')
def mujoco_model():
    """Return a function: arm -> mujoco.MjModel, joint angles those of the record."""
    mujoco = pytest.importorskip('mujoco')

    def build(arm):
        opened = []
        place = 'pos="0 0 0"'
        for i, (mass, com, inertia) in enumerate(zip(*arm.bodies, strict=True)):
            c, s = np.cos(arm.alpha[i]), np.sin(arm.alpha[i])
            turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            centre = turn @ com + (arm.a[i], 0, arm.d[i])
            tensor = turn @ inertia @ turn.T
            six = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            opened.append(
                f'<body {place}><inertial pos="{_text(centre)}" mass="{float(mass)!r}" '
                f'fullinertia="{_text(six)}"/><joint type="hinge" axis="0 0 1" '
                f'armature="{float(arm.armature[i])!r}"/>')
            half = 0.5 * arm.alpha[i]
            place = (f'pos="{_text((arm.a[i], 0, arm.d[i]))}" '
                     f'quat="{_text((np.cos(half), np.sin(half), 0, 0))}"')
        return mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler angle="radian" boundmass="0" boundinertia="0"/>'
            f'<option gravity="{_text(arm.gravity)}"><flag contact="disable"/></option>'
            f'<worldbody>{"".join(opened)}{"</body>" * 6}</worldbody></mujoco>')

    return build


def _text(numbers):
    return ' '.join(repr(float(x)) for x in numbers)
