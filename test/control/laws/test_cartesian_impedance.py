"""The Cartesian impedance: a mass on a spring, with Pinocchio as the witness; refusals."""

import numpy as np
import pinocchio
import pytest

from ur5_ros.config import load_arm
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.worlds import load_world
from ur5_ros.control.controller import Controller
from ur5_ros.control.gains import gains_from
from ur5_ros.control.laws.cartesian_impedance import CartesianImpedance, limited_inverse
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.signals import ArmState, Reference
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.urdf import urdf_text

ARM = load_arm('ur5_real')
K = np.diag([1000.0, 800.0, 1200.0, 30.0, 20.0, 10.0])
D = np.diag([200.0, 150.0, 250.0, 2.0, 1.5, 1.0])
WRENCH = np.array([3.0, -2.0, 5.0, 0.1, 0.2, -0.3])
MODE = {'mode': 'cartesian_impedance'}


def sample(seed):
    rng = np.random.default_rng(seed)
    q = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2]) + rng.uniform(-0.3, 0.3, 6)
    state = ArmState(0, q, rng.uniform(-0.5, 0.5, 6), np.zeros(6))
    near = q + rng.uniform(-0.02, 0.02, 6)
    return state, Reference(near, rng.uniform(-0.5, 0.5, 6), rng.uniform(-1.0, 1.0, 6))


class Tool:
    """Acceleration of the tool under joint torques, by Pinocchio, in base."""

    def __init__(self):
        self.model = pinocchio.buildModelFromXML(urdf_text(ARM))
        self.data = self.model.createData()
        self.frame = self.model.getFrameId('tool0')
        self.turn = np.diag([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])  # base <- base_link

    def motion(self, q, qd, qdd):
        """Return position, velocity and acceleration of tool0, in base."""
        pinocchio.forwardKinematics(self.model, self.data, q, qd, qdd)
        pinocchio.updateFramePlacements(self.model, self.data)
        axes = pinocchio.LOCAL_WORLD_ALIGNED
        v, a = (self.turn @ get(self.model, self.data, self.frame, axes).vector for get in (
            pinocchio.getFrameVelocity, pinocchio.getFrameClassicalAcceleration))
        return self.data.oMf[self.frame].homogeneous.copy(), v, a

    def acceleration(self, state, tau, wrench):
        """Return qdd under joint torques and a wrench on the tool in base."""
        q, qd = state.q, state.qd
        J = self.turn @ pinocchio.computeFrameJacobian(
            self.model, self.data, q, self.frame, pinocchio.LOCAL_WORLD_ALIGNED)
        M = pinocchio.crba(self.model, self.data, q)
        M = np.triu(M) + np.triu(M, 1).T + np.diag(ARM.armature)
        bias = pinocchio.nonLinearEffects(self.model, self.data, q, qd)
        return np.linalg.solve(M, tau + J.T @ wrench - bias), J, M


@pytest.mark.parametrize('frame', ['base', 'tool'])
@pytest.mark.parametrize('inertia', [None, np.diag([5.0, 4.0, 6.0, 0.3, 0.2, 0.1])],
                         ids=['own inertia', 'shaped inertia'])
@pytest.mark.parametrize('seed', range(5))
def test_the_tool_obeys_the_equation_of_a_mass_on_a_spring(frame, inertia, seed):
    state, reference = sample(seed)
    tool, contact = Tool(), np.array([1.0, 2.0, -20.0, 0.3, 0.1, -0.2])
    given = ControlParameters.of({
        'impedance.stiffness': np.diag(K).tolist(), 'impedance.damping': np.diag(D).tolist(),
        'impedance.inertia': [] if inertia is None else np.diag(inertia).tolist(),
        'impedance.frame': frame})
    law = CartesianImpedance(ARM, gains_from(given.kp, given.kd), given)
    law.target_wrench = WRENCH
    torque = law(state, reference, 1e-3)
    qdd, J, M = tool.acceleration(state, torque.total, contact)
    pose, v, a = tool.motion(state.q, state.qd, qdd)
    target, v_star, a_star = tool.motion(*reference)
    turned = np.diag([-1.0, -1.0, 1.0]) @ pose[:3, :3], np.diag([-1.0, -1.0, 1.0]) @ target[:3, :3]
    e = np.concatenate([np.diag([-1.0, -1.0, 1.0]) @ (pose[:3, 3] - target[:3, 3]),
                        pinocchio.log3(turned[0] @ turned[1].T)])
    axes = np.kron(np.eye(2), turned[0]) if frame == 'tool' else np.eye(6)
    force = WRENCH - axes @ K @ axes.T @ e - axes @ D @ axes.T @ (v - v_star)
    own = np.linalg.inv(J @ np.linalg.solve(M, J.T))
    if inertia is None:
        left = own @ (a - a_star) - force - contact
    else:
        shaped = axes @ inertia @ axes.T
        left = shaped @ (a - a_star) - force - shaped @ np.linalg.solve(own, contact)
    assert np.abs(left).max() < 1e-9 * max(1.0, np.abs(force).max())
    parts = torque.inertial + torque.feedback + torque.coriolis + torque.gravity
    assert np.abs(parts - torque.total).max() < 1e-12


def test_the_inverse_is_limited_near_a_singularity_and_exact_away_from_one():
    q = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])
    J = jacobian(q, ARM)
    assert np.abs(limited_inverse(J) @ J - np.eye(6)).max() < 1e-12
    q[4] = 0.0  # wrist
    J = jacobian(q, ARM)
    assert np.linalg.norm(limited_inverse(J), 2) <= 10.0 + 1e-9
    controller = Controller(ARM, MODE)
    controller.update(ArmState(1, q, np.zeros(6), np.zeros(6)))
    assert controller.status()['inverse_limited']


@pytest.mark.parametrize(('given', 'words'), [
    ({'impedance.stiffness': [-1.0] + [1.0] * 5}, 'impedance.stiffness has the eigenvalue -1'),
    ({'impedance.damping': [0.0] * 6}, 'impedance.damping has the eigenvalue 0'),
    ({'impedance.stiffness': [float(i) for i in range(36)]}, 'differs from its transpose'),
    ({'impedance.damping': [200.0, 200.0, 200.0, 2.0, 2.0, 2.0]}, 'unstable .*about z'),
])
def test_an_impedance_that_is_none_or_shakes_the_arm_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        Controller(load_arm('ur5'), {**MODE, **given})


def test_gains_change_live_and_bad_ones_leave_the_old_in_force():
    controller = Controller(ARM, MODE)
    controller.change({'impedance.stiffness': [500.0] * 3 + [10.0] * 3})
    with pytest.raises(InputError, match='eigenvalue'):
        controller.change({'impedance.stiffness': [-500.0] * 6})
    assert controller.parameters.impedance_stiffness == [500.0] * 3 + [10.0] * 3


class OnTable:
    """The arm over the table of the package, under a controller."""

    def __init__(self, height=0.09, **given):
        arm = load_arm('ur5')
        self.pose = np.diag([1.0, -1.0, -1.0, 1.0])
        self.pose[:3, 3] = -0.45, -0.15, height
        from ur5_ros.model.inverse_kinematics import nearest_solution
        near = np.deg2rad([20.0, -75.0, 90.0, -105.0, -90.0, 15.0])
        start = np.ravel(nearest_solution(self.pose, near, arm, arm.limits))[:6]
        self.plant = Plant(arm, {'world': 'table', 'initial_positions': start.tolist()})
        self.controller = Controller(arm, {**MODE, **given}, 1000)

    def run(self, periods):
        for _ in range(periods):
            torque = self.controller.update(self.plant.state).torque
            self.plant.step(torque.total)
        return self.plant.mechanics.contacts[-1].force.sum(axis=0)

    def tool(self):
        return forward_kinematics(self.plant.truth.q, self.plant.arm)[:3, 3]


def test_a_desired_wrench_is_reached_and_a_stiffness_presses_with_depth():
    arm = OnTable(height=0.0701)  # the finger's end is 70 mm below the flange
    arm.run(10)
    arm.controller.target_wrench((0.0, 0.0, -20.0), (0.0, 0.0, 0.0))
    spring = 1000.0 * 1e-4  # of the way down that the spring holds back
    assert arm.run(3000)[2] == pytest.approx(20.0 - spring, rel=1e-3)
    arm.controller.target_wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    target = arm.pose.copy()
    target[2, 3] = 0.05
    arm.controller.target_pose(target)
    force = arm.run(5000)[2]
    assert force == pytest.approx(1000.0 * (arm.tool()[2] - 0.05), rel=1e-3)
    assert force == pytest.approx(20.0, rel=1e-3)


def test_a_desired_wrench_is_refused_in_another_mode_and_in_an_unknown_frame():
    arm = OnTable()
    arm.run(2)
    with pytest.raises(InputError, match='wrench in frame .world.'):
        arm.controller.target_wrench((0.0, 0.0, -1.0), (0.0, 0.0, 0.0), 'world')
    arm.controller.change({'mode': 'computed_torque'})
    with pytest.raises(InputError, match='set mode to cartesian_impedance first'):
        arm.controller.target_wrench((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))


def test_a_guarded_path_ends_where_the_tool_meets_the_force():
    arm = OnTable(guard_force=5.0)
    arm.run(10)
    down = np.repeat(arm.pose[None], 2, axis=0)
    down[1, 2, 3] = 0.02  # half a finger into the table
    arm.controller.path(down)
    arm.run(2000)
    assert 'guard_force is 5 N' in arm.controller.status()['detail']
    assert load_world('table').bodies[0].name == 'table'
    assert arm.tool()[2] == pytest.approx(0.07, abs=1e-4)
    assert arm.plant.mechanics.contacts[-1].force.sum(axis=0)[2] < 20.0
