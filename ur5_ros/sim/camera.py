"""Pictures of the arm without a screen: PyBullet's software renderer."""

import tempfile

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.pybullet_import import pybullet
from ur5_ros.sim.urdf import urdf_text

_EYE = (0.85, 1.15, 0.95)
_TARGET = (0.0, 0.05, 0.38)
_FIELD_OF_VIEW = 38.0
_NEAR, _FAR = 0.05, 10.0


class Camera:
    """
    A camera that looks at an arm standing on the floor, in the frame ``base_link``.

    Parameters
    ----------
    arm : ArmParameters
        The arm.
    width, height : int
        Size of the pictures [pixels].

    """

    def __init__(self, arm: ArmParameters, width: int, height: int):
        self.width, self.height = width, height
        reach = float(np.abs(arm.a[1:3]).sum() + np.abs(arm.d).sum()) / 1.18
        eye, target = (tuple(reach * x for x in point) for point in (_EYE, _TARGET))
        self._view = pybullet.computeViewMatrix(eye, target, (0.0, 0.0, 1.0))
        self._projection = pybullet.computeProjectionMatrixFOV(
            _FIELD_OF_VIEW, width / height, _NEAR * reach, _FAR * reach)
        self._client = pybullet.connect(pybullet.DIRECT)
        if self._client < 0:
            raise InputError('PyBullet cannot start another world; close one')
        with tempfile.NamedTemporaryFile('w', suffix='.urdf', encoding='utf-8') as file:
            file.write(urdf_text(arm))
            file.flush()
            self._body = pybullet.loadURDF(file.name, useFixedBase=True,
                                           physicsClientId=self._client)
        moving = [i for i in range(pybullet.getNumJoints(self._body, self._client))
                  if pybullet.getJointInfo(self._body, i, self._client)[2]
                  == pybullet.JOINT_REVOLUTE]
        self._joints = moving

    def picture(self, q: np.ndarray) -> np.ndarray:
        """Return the arm at ``q`` [rad] on white as an image (height, width, 3) of bytes."""
        cut = self.cutout(q)
        return np.where(cut[..., 3:] > 0, cut[..., :3], np.uint8(255))

    def cutout(self, q: np.ndarray) -> np.ndarray:
        """
        Return the arm without any ground.

        Parameters
        ----------
        q : numpy.ndarray, shape (6,)
            Joint positions [rad].

        Returns
        -------
        numpy.ndarray, shape (height, width, 4)
            Bytes of red, green and blue, and 255 where the arm is, 0 elsewhere.

        """
        for joint, angle in zip(self._joints, q, strict=True):
            pybullet.resetJointState(self._body, joint, float(angle),
                                     physicsClientId=self._client)
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

    def close(self) -> None:
        """End the world; closing twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
