"""Plants that are closed again, and Pinocchio as the witness."""

import numpy as np
import pinocchio
import pytest

from ur5_ros.config import list_arms, load_arm
from ur5_ros.sim.plant import plant_from_parameters
from ur5_ros.sim.urdf import urdf_text

#: Every arm that has tensors.
SIMULATED = [name for name in list_arms() if load_arm(name).has_tensors]


@pytest.fixture(params=SIMULATED)
def every_arm(request):
    return load_arm(request.param)


@pytest.fixture
def plant_of():
    """Return a function from parameters (dots written as __) to a plant."""
    plants = []

    def make(**given):
        parameters = {name.replace('__', '.'): value for name, value in given.items()}
        plants.append(plant_from_parameters(parameters))
        return plants[-1]

    yield make
    for plant in plants:
        plant.close()


class Witness:
    """M, h, J and forward dynamics of an arm by Pinocchio, from the URDF, in the axes of base."""

    def __init__(self, arm):
        self.model = pinocchio.buildModelFromXML(urdf_text(arm))
        self.model.armature = np.array(arm.armature)
        self.set_gravity(arm.gravity)
        self.data = self.model.createData()
        self.tool = self.model.getFrameId('tool0')

    def set_gravity(self, gravity):
        """Set gravity, given in base; Pinocchio's world is base_link."""
        self.model.gravity.linear = np.array(gravity) * [-1.0, -1.0, 1.0]

    def configuration(self, q):
        """Return q as Pinocchio wants it: a continuous joint is a point on the circle."""
        return np.concatenate([[np.cos(x), np.sin(x)] if joint.nq == 2 else [x]
                               for x, joint in zip(q, list(self.model.joints)[1:], strict=True)])

    def frames(self, q):
        """Return where every frame is in base_link, by name."""
        pinocchio.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return {frame.name: pose.homogeneous
                for frame, pose in zip(self.model.frames, self.data.oMf, strict=True)}

    def mass_matrix(self, q):
        M = pinocchio.crba(self.model, self.data, self.configuration(q))
        return np.triu(M) + np.triu(M, 1).T

    def bias(self, q, qd):
        return pinocchio.nonLinearEffects(self.model, self.data, self.configuration(q),
                                          np.array(qd))

    def acceleration(self, q, qd, tau):
        return pinocchio.aba(self.model, self.data, self.configuration(q), np.array(qd),
                             np.array(tau))

    def jacobian(self, q):
        J = pinocchio.computeFrameJacobian(self.model, self.data, self.configuration(q), self.tool,
                                           pinocchio.LOCAL_WORLD_ALIGNED)
        turn = np.diag([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])  # base <- base_link
        return turn @ J

    def energy(self, q, qd):
        # Without rotor inertia, which Pinocchio leaves out here.
        return (pinocchio.computeKineticEnergy(self.model, self.data, self.configuration(q), qd)
                + 0.5 * np.sum(self.model.armature * np.square(qd))
                + pinocchio.computePotentialEnergy(self.model, self.data, self.configuration(q)))


@pytest.fixture
def witness_of():
    return Witness
