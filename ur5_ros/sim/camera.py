"""Pictures of the arm without a screen: PyBullet's software renderer."""

import tempfile
from collections.abc import Sequence

import numpy as np

from ur5_ros.config.worlds import NOTHING, Body, World
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.sim.pybullet_import import pybullet
from ur5_ros.sim.urdf import urdf_text

_EYE = (0.85, 1.15, 0.95)
_TARGET = (0.0, 0.05, 0.38)
_FIELD_OF_VIEW = 38.0
#: How much further away the camera stands where there is more than the arm to be seen.
_WIDER = 1.25
_NEAR, _FAR = 0.05, 10.0
#: The frame ``base`` in ``base_link``.
_BASE = np.diag([-1.0, -1.0, 1.0, 1.0])
#: Half the edges of the plate that stands for a plane [m].
_PLATE = (2.0, 2.0, 5e-4)
#: Where bodies wait that are not in the picture [m].
_OUT_OF_SIGHT = np.eye(4)
_OUT_OF_SIGHT[2, 3] = -1e3


class Camera:
    """
    A camera that looks at an arm standing on the floor, in the frame ``base_link``.

    Parameters
    ----------
    arm : ArmParameters
        The arm.
    width, height : int
        Size of the pictures [pixels].
    world : World
        What stands around the arm, and its tool; meshes are left out.

    """

    def __init__(self, arm: ArmParameters, width: int, height: int, world: World = NOTHING):
        self.width, self.height = width, height
        reach = float(np.abs(arm.a[1:3]).sum() + np.abs(arm.d).sum()) / 1.18
        target = reach * np.array(_TARGET)
        eye = target + (reach * np.array(_EYE) - target) * (_WIDER if world.bodies else 1.0)
        self._view = pybullet.computeViewMatrix(eye.tolist(), target.tolist(), (0.0, 0.0, 1.0))
        self._projection = pybullet.computeProjectionMatrixFOV(
            _FIELD_OF_VIEW, width / height, _NEAR * reach, _FAR * reach)
        self._client = pybullet.connect(pybullet.DIRECT)
        if self._client < 0:
            raise InputError('PyBullet cannot start another world; close one')
        with tempfile.NamedTemporaryFile('w', suffix='.urdf', encoding='utf-8') as file:
            file.write(urdf_text(arm, world=world))
            file.flush()
            self._body = pybullet.loadURDF(file.name, useFixedBase=True,
                                           physicsClientId=self._client)
        moving = [i for i in range(pybullet.getNumJoints(self._body, self._client))
                  if pybullet.getJointInfo(self._body, i, self._client)[2]
                  == pybullet.JOINT_REVOLUTE]
        self._joints = moving
        self._bodies = [self._create(body) for body in world.bodies]
        self._place(())

    def picture(self, q: np.ndarray, poses: np.ndarray | None = None) -> np.ndarray:
        """Return the :meth:`cutout` on white as an image (height, width, 3) of bytes."""
        cut = self.cutout(q, poses)
        return np.where(cut[..., 3:] > 0, cut[..., :3], np.uint8(255))

    def cutout(self, q: np.ndarray, poses: np.ndarray | None = None) -> np.ndarray:
        """
        Return the arm and the world without any ground.

        Parameters
        ----------
        q : numpy.ndarray, shape (6,)
            Joint positions [rad].
        poses : numpy.ndarray, shape (n, 4, 4), optional
            Of the bodies of the world, in ``base``; without them none is in the picture.

        Returns
        -------
        numpy.ndarray, shape (height, width, 4)
            Bytes of red, green and blue, and 255 where the arm or a body is, 0 elsewhere.

        """
        for joint, angle in zip(self._joints, q, strict=True):
            pybullet.resetJointState(self._body, joint, float(angle),
                                     physicsClientId=self._client)
        self._place(() if poses is None else poses)
        # no shadows: the renderer throws an arm's shadow on itself in ragged patches
        _, _, pixels, _, body = pybullet.getCameraImage(
            self.width, self.height, self._view, self._projection, shadow=0,
            lightDirection=(0.6, 1.0, 2.0), lightDistance=3.0, lightAmbientCoeff=0.6,
            lightDiffuseCoeff=0.5, lightSpecularCoeff=0.1,
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=self._client)
        cut = np.array(pixels, dtype=np.uint8).reshape(self.height, self.width, 4)
        cut[..., 3] = np.where(np.reshape(body, cut.shape[:2]) >= 0, 255, 0)
        return cut

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Return where points (n, 3) [m] in ``base_link`` stand in the picture: (n, 2) [px]."""
        view = np.reshape(self._view, (4, 4)).T
        projection = np.reshape(self._projection, (4, 4)).T
        ahead = np.c_[points, np.ones(len(points))] @ (projection @ view).T
        spot = ahead[:, :2] / ahead[:, 3:]
        return np.c_[(spot[:, 0] + 1) * self.width / 2, (1 - spot[:, 1]) * self.height / 2]

    def _create(self, body: Body) -> int:
        """Add the looks of a body; return its number, -1 for a mesh."""
        kinds = {'box': pybullet.GEOM_BOX, 'plane': pybullet.GEOM_BOX,
                 'sphere': pybullet.GEOM_SPHERE, 'cylinder': pybullet.GEOM_CYLINDER}
        if body.shape not in kinds:
            return -1
        half = _PLATE if body.shape == 'plane' else [edge / 2 for edge in body.size] or [1.0] * 3
        looks = pybullet.createVisualShape(
            kinds[body.shape], radius=body.radius, length=body.length, halfExtents=half,
            rgbaColor=[*body.colour, 1.0], physicsClientId=self._client)
        return pybullet.createMultiBody(0.0, baseVisualShapeIndex=looks,
                                        physicsClientId=self._client)

    def _place(self, poses: Sequence[np.ndarray] | np.ndarray) -> None:
        """Put the bodies at poses in ``base``; out of sight where none is given."""
        for i, body in enumerate(self._bodies):
            pose = _BASE @ poses[i] if i < len(poses) else _OUT_OF_SIGHT
            if body >= 0:
                place, turn = position_and_quaternion(pose)
                pybullet.resetBasePositionAndOrientation(body, place.tolist(), turn.tolist(),
                                                         self._client)

    def close(self) -> None:
        """End the world; closing twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
