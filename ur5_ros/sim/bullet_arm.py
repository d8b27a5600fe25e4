"""The arm in PyBullet: the only file that knows the engine and its traps."""

import tempfile
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.display import check_display
from ur5_ros.sim.pybullet_import import pybullet
from ur5_ros.sim.urdf import link_bodies, urdf_text

if TYPE_CHECKING:
    from ur5_ros.sim.world.bullet_scene import BulletScene

_ZEROS = [0.0] * 6
_TORQUE = pybullet.TORQUE_CONTROL


class Joints(NamedTuple):
    """Joint state as PyBullet takes and gives it."""

    q: Sequence[float]
    qd: Sequence[float]


class BulletArm:
    """
    Six joints and gravity in a PyBullet world of their own, whose world frame is ``base``.

    The integrator is qd' = qd + h M^-1 (tau - C qd - g), q' = q + h qd': nothing is added to it.
    Damping, motors and PyBullet's velocity clamp are off; the joints have no stops here.  Joint
    states travel as sequences of floats, which is what PyBullet takes and gives.

    ``gravity`` (3,): gravitational acceleration in ``base`` [m/s^2]; ``step_time``: length h of a
    physics step [s]; ``scene``: bodies around the arm, which then has the shapes that touch them.

    """

    def __init__(self, arm: ArmParameters, gravity: np.ndarray, step_time: float,
                 gui: bool = False, scene: 'BulletScene | None' = None):
        self._step_time, self._gui, self._scene = step_time, gui, scene
        urdf_text(arm, bare=True, shapes=False)  # refuses before a world is opened
        if gui:
            check_display()
        try:
            self._client = pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT)
        except pybullet.error as error:
            raise InputError(f'PyBullet cannot start: {error}; close another simulator') from None
        if self._client < 0:
            raise InputError('PyBullet cannot start; close another simulator')
        self.load(arm, gravity)
        if gui:
            pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0,
                                              physicsClientId=self._client)
            pybullet.resetDebugVisualizerCamera(1.8, 50.0, -25.0, [0.0, 0.0, 0.3],
                                                physicsClientId=self._client)

    def load(self, arm: ArmParameters, gravity: Sequence[float] | np.ndarray) -> None:
        """Build the world again with these bodies, at rest in zero position; see :meth:`place`."""
        client = self._client
        pybullet.resetSimulation(physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self._step_time, numSubSteps=0, deterministicOverlappingPairs=1,
            physicsClientId=client)
        with tempfile.NamedTemporaryFile('w', suffix='.urdf', encoding='utf-8') as file:
            file.write(urdf_text(arm, bare=True, shapes=self._gui,
                                 world=self._scene.world if self._scene else None))
            file.flush()
            body = pybullet.loadURDF(file.name, useFixedBase=True, physicsClientId=client,
                                     flags=self._flags())
        # Body-wide settings alone and on link -1: mixed with others they are silently lost.
        pybullet.changeDynamics(body, -1, linearDamping=0, angularDamping=0,
                                physicsClientId=client)
        pybullet.changeDynamics(body, -1, maxJointVelocity=1e9, physicsClientId=client)
        self._body, self._joints = body, list(range(6))
        if self._scene is not None:
            self._scene.build(client, body)
        for joint in self._joints:
            pybullet.changeDynamics(body, joint, jointDamping=0.0, physicsClientId=client)
        pybullet.setJointMotorControlArray(body, self._joints, pybullet.VELOCITY_CONTROL,
                                           forces=_ZEROS, physicsClientId=client)
        turn = pybullet.getMatrixFromQuaternion(
            pybullet.getQuaternionFromEuler(link_bodies(arm)[5][2]))
        self._axes = np.array(turn).reshape(3, 3)
        self.set_gravity(gravity)
        self.advance = self.stepper()
        """Takes a step: torques [N m] in; q [rad] and qd [rad/s] out, twelve numbers."""

    def _flags(self) -> int:
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        if self._scene is not None:  # other cylinders are a millimetre too large
            flags |= pybullet.URDF_USE_IMPLICIT_CYLINDER
            if self._scene.world.self_contact:
                flags |= pybullet.URDF_USE_SELF_COLLISION
        return flags

    def set_gravity(self, gravity: Sequence[float] | np.ndarray) -> None:
        """Set the gravitational acceleration, in ``base`` [m/s^2]."""
        pybullet.setGravity(*map(float, gravity), physicsClientId=self._client)

    def place(self, q: Sequence[float], qd: Sequence[float]) -> None:
        """Put the joints at these positions [rad] and velocities [rad/s]."""
        q1, q2, q3, q4, q5, q6 = q
        v1, v2, v3, v4, v5, v6 = qd
        # lists outside: tuples crash PyBullet
        pybullet.resetJointStatesMultiDof(
            self._body, self._joints, [(q1,), (q2,), (q3,), (q4,), (q5,), (q6,)],
            [(v1,), (v2,), (v3,), (v4,), (v5,), (v6,)], self._client)

    def pose(self, q: Sequence[float]) -> None:
        """Put the joints at these positions [rad]; only to look for contact there."""
        q1, q2, q3, q4, q5, q6 = q
        pybullet.resetJointStatesMultiDof(
            self._body, self._joints, [(q1,), (q2,), (q3,), (q4,), (q5,), (q6,)],
            physicsClientId=self._client)

    def stepper(self) -> Callable[[Sequence[float]], tuple[float, ...]]:
        """Return what :attr:`advance` is: a function bound to the bodies that are loaded now."""
        body, joints, client, torque = self._body, self._joints, self._client, _TORQUE
        set_torque, step = pybullet.setJointMotorControlArray, pybullet.stepSimulation
        read = pybullet.getJointStates

        def advance(tau: Sequence[float]) -> tuple[float, ...]:
            # a torque lasts one step; two calls before a step would add up
            # by position, as names cost a quarter of a microsecond: torque control reads `forces`
            set_torque(body, joints, torque, tau, tau, tau, tau, tau, client)
            step(client)
            ((q1, v1, _, _), (q2, v2, _, _), (q3, v3, _, _), (q4, v4, _, _), (q5, v5, _, _),
             (q6, v6, _, _)) = read(body, joints, client)
            return q1, q2, q3, q4, q5, q6, v1, v2, v3, v4, v5, v6

        return advance

    def mass_matrix(self, q: Sequence[float]) -> np.ndarray:
        """Return M(q) of the loaded bodies [kg m^2], shape (6, 6), without rotor inertia."""
        return np.array(pybullet.calculateMassMatrix(self._body, q, physicsClientId=self._client))

    def bias(self, q: Sequence[float], qd: Sequence[float] = _ZEROS) -> np.ndarray:
        """Return C(q, qd) qd + g(q) [N m], shape (6,)."""
        return np.array(pybullet.calculateInverseDynamics(self._body, q, qd, _ZEROS,
                                                          physicsClientId=self._client))

    def mass_and_bias(self, q: Sequence[float], qd: Sequence[float]) -> tuple[tuple, tuple]:
        """Return :meth:`mass_matrix` as rows and :meth:`bias`, as PyBullet gives them."""
        body, client = self._body, self._client
        # names of arguments take a quarter of a microsecond; 0 stands for no flags
        return (pybullet.calculateMassMatrix(body, q, 0, client),
                pybullet.calculateInverseDynamics(body, q, qd, _ZEROS, 0, client))

    def jacobian(self, q: Sequence[float], point: Sequence[float] = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return J(q) of a point of ``tool0``, linear rows first, in ``base``; (6, 6)."""
        # PyBullet counts a point from the origin of the link, along its principal axes of inertia.
        local = (self._axes.T @ point).tolist()
        linear, angular = pybullet.calculateJacobian(
            self._body, self._joints[-1], local, q, _ZEROS, _ZEROS, physicsClientId=self._client)
        return np.array(linear + angular)

    def close(self) -> None:
        """Disconnect; closing twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
