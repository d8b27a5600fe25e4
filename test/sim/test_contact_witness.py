"""MuJoCo, with rotor inertia and the same shapes, as the witness of contact."""

import mujoco
import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.worlds import base_pose, load_world
from ur5_ros.control.experiment import experiment_trajectory
from ur5_ros.control.gains import gains_from
from ur5_ros.control.laws.cartesian_impedance import CartesianImpedance
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.signals import ArmState
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.urdf import urdf_text

TURN = np.diag([-1.0, -1.0, 1.0])  # base_link <- base
KINDS = {'box': mujoco.mjtGeom.mjGEOM_BOX, 'sphere': mujoco.mjtGeom.mjGEOM_SPHERE,
         'cylinder': mujoco.mjtGeom.mjGEOM_CYLINDER}
#: MuJoCo's contacts are springs: the stiffest that its step of 0.1 ms carries.
STIFF = {'solref': [0.0005, 1.0], 'solimp': [0.99, 0.9999, 1e-5, 0.5, 2.0]}


class MujocoWorld:
    """The arm and a world in MuJoCo, world frame base_link."""

    def __init__(self, arm, world, q, step=1e-4):
        spec = mujoco.MjSpec.from_string(urdf_text(arm, shapes=False))
        option = spec.option
        option.timestep, option.impratio, option.tolerance = step, 100.0, 1e-12
        option.cone, option.iterations = mujoco.mjtCone.mjCONE_ELLIPTIC, 200
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
        touching = []
        for i, solid in enumerate(world.tool):
            spec.body('wrist_3_link').add_geom(name=f'tool{i}', mass=0.0, pos=solid.position,
                                               **self._shape(solid))
            touching.append((f'tool{i}', 1.0))
        for body in world.bodies:
            pose = base_pose(body, world.frame)
            x, y, z, w = quaternion_of(TURN @ pose[:3, :3])
            place = {'pos': TURN @ pose[:3, 3], 'quat': [w, x, y, z]}
            if body.free:
                free = spec.worldbody.add_body(name=body.name, **place)
                free.add_freejoint()
                free.add_geom(name=body.name, mass=body.mass, **self._shape(body))
            else:
                spec.worldbody.add_geom(name=body.name, **place, **self._shape(body))
            others = touching + [(other.name, other.friction) for other in world.bodies
                                 if body.free and not other.free]
            for name, friction in others:
                spec.add_pair(geomname1=name, geomname2=body.name, condim=3,
                              friction=[friction * body.friction] * 2 + [0.0] * 3, **STIFF)
        self.model = spec.compile()
        self.model.dof_armature[:6] = arm.armature
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:6] = q
        self._steps = round(1e-3 / step)
        mujoco.mj_forward(self.model, self.data)

    @staticmethod
    def _shape(solid):
        size = {'box': [edge / 2 for edge in solid.size], 'sphere': [solid.radius, 0.0, 0.0],
                'cylinder': [solid.radius, solid.length / 2, 0.0]}[solid.shape]
        return {'type': KINDS[solid.shape], 'size': size}

    @property
    def state(self):
        return ArmState(0, self.data.qpos[:6].copy(), self.data.qvel[:6].copy(), np.zeros(6))

    def step(self, tau):
        self.data.qfrc_applied[:6] = tau
        for _ in range(self._steps):
            mujoco.mj_step(self.model, self.data)

    def force_on(self, name):
        """Return the force of all contacts on a geom, in base [N]."""
        total, force = np.zeros(3), np.zeros(6)
        for i, contact in enumerate(self.data.contact):
            names = [self.model.geom(geom).name for geom in (contact.geom1, contact.geom2)]
            if name in names:
                mujoco.mj_contactForce(self.model, self.data, i, force)
                turned = contact.frame.reshape(3, 3).T @ force[:3]
                total += turned if names[1] == name else -turned
        return TURN @ total


def both(experiment, arm_name, seconds):
    """Run an experiment in the plant and in MuJoCo, each under its own law; return both."""
    arm, spec = load_arm(arm_name), load_experiment(experiment)
    given = ControlParameters.of(spec.control)
    law = CartesianImpedance(arm, gains_from(given.kp, given.kd), given)
    motion = experiment_trajectory(spec, arm, 1000, 0.02).trajectory
    start = motion.at(0).q
    plant = Plant(arm, {'world': spec.world, 'initial_positions': start.tolist()})
    witness = MujocoWorld(arm, load_world(spec.world), start)
    for k in range(round(seconds * 1000)):
        reference = motion.at(k * 1_000_000)
        plant.step(law(plant.state, reference, 1e-3).total)
        witness.step(law(witness.state, reference, 1e-3).total)
    return plant, witness


def test_a_pressed_finger_rests_with_mujocos_force():
    plant, witness = both('press_and_slide', 'ur5', 4.0)
    force = plant.mechanics.contacts[-1].force.sum(axis=0)
    assert force[2] == pytest.approx(20.0, rel=1e-3)
    assert force[2] == pytest.approx(witness.force_on('tool1')[2], abs=1e-3)
    plant.close()


def test_a_pushed_block_goes_as_far_as_mujocos():
    # Where the finger meets the block MuJoCo's spring gives way and the rigid contact here does
    # not: the first milliseconds differ, the way does not.
    plant, witness = both('push_block', 'ur5_real', 4.2)
    (_, place, _), = plant.mechanics.objects()
    way, other = place[1], TURN[1, 1] * witness.data.qpos[7]
    assert way > 0.09
    assert way == pytest.approx(other, rel=0.02)
    plant.close()
